//! Rows of frames: one behind the other, as the reader wants them.

use super::FrameRecord;

/// What the rule E0703 has against a frame behind another one.
pub(super) fn misplaced(before: Option<&FrameRecord>, frame: &FrameRecord) -> Option<String> {
    let number = frame.number;
    match before {
        Some(before) if before.number >= number => {
            return Some(format!("frame {number} comes after frame {}, and numbers ascend", before.number));
        }
        _ if frame.flags & FrameRecord::HELD == 0 => {}
        Some(before) if before.placement == frame.placement => {}
        Some(before) => return Some(format!("frame {number} holds frame {}, but shows something else", before.number)),
        None => return Some(format!("frame {number} holds the frame before, and there is none")),
    }
    (!frame.time.is_finite()).then(|| format!("frame {number} is at the time {}, and times are finite", frame.time))
}
