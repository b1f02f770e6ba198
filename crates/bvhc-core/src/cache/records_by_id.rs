//! [`RecordsById`]: from an instance's number to its record, for many hits.

use crate::layout::InstanceRecord;

/// Which record of `INST` has which number.
#[derive(Clone, Debug, Default)]
pub struct RecordsById {
    by_id: Vec<u32>,
}

impl RecordsById {
    /// Of these records.
    pub fn new(instances: &[InstanceRecord]) -> RecordsById {
        // As many as there are records, whatever their numbers are.
        let mut by_id = vec![u32::MAX; instances.len()];
        for (record, instance) in instances.iter().enumerate() {
            if let Some(place) = by_id.get_mut(instance.id as usize) {
                *place = record as u32;
            }
        }
        RecordsById { by_id }
    }

    /// The index of the record with this number.
    pub fn record(&self, id: u32) -> Option<usize> {
        self.by_id.get(id as usize).map(|record| *record as usize).filter(|record| *record < self.by_id.len())
    }
}
