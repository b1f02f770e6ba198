//! Numbers for people: grouped counts, durations, percentages; and sizes as people write them. How they read sizes, [`size`](crate::size) says.

use crate::exec::Executor;
use std::time::Duration;

/// `69451` as `69,451`.
pub fn count(n: impl Into<u64>) -> String {
    let digits = n.into().to_string();
    let mut out = String::with_capacity(digits.len() + digits.len() / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// `1 ray`, `69,451 rays`.
pub fn counted(n: u64, one: &str, many: &str) -> String {
    format!("{} {}", count(n), if n == 1 { one } else { many })
}

/// Seconds as milliseconds of three digits, without their unit.
pub fn milliseconds(seconds: f64) -> String {
    let ms = 1e3 * seconds;
    match ms {
        _ if ms >= 100.0 => format!("{ms:.0}"),
        _ if ms >= 10.0 => format!("{ms:.1}"),
        _ => format!("{ms:.2}"),
    }
}

/// `0.41 s`, `12.3 s`; below 10 ms in milliseconds.
pub fn seconds(d: Duration) -> String {
    let s = d.as_secs_f64();
    if s < 0.01 {
        format!("{:.1} ms", s * 1e3)
    } else if s < 10.0 {
        format!("{s:.2} s")
    } else {
        format!("{s:.1} s")
    }
}

/// A SAH or similar cost: three or four significant digits.
pub fn cost(v: f64) -> String {
    if v >= 100.0 { format!("{v:.0}") } else { format!("{v:.1}") }
}

/// The reading of `512M`, `8G`, `1048576`: binary multiples, as memory is counted.
pub fn parse_size(text: &str) -> Result<u64, String> {
    let bad = || format!("`{text}` is not a size; write a number of bytes or a number with K, M, G or T, such as 512M");
    let upper = text.trim().to_ascii_uppercase();
    let upper = upper.strip_suffix("IB").or_else(|| upper.strip_suffix('B')).unwrap_or(&upper);
    let (digits, shift) = match upper.char_indices().next_back().ok_or_else(bad)? {
        (i, 'K') => (&upper[..i], 10),
        (i, 'M') => (&upper[..i], 20),
        (i, 'G') => (&upper[..i], 30),
        (i, 'T') => (&upper[..i], 40),
        _ => (upper, 0),
    };
    let number: u64 = digits.trim().parse().map_err(|_| bad())?;
    number.checked_mul(1 << shift).ok_or_else(|| format!("`{text}` is more than this machine can address"))
}

/// The reading of `60s`, `2m`, `500ms`: how long something may take. A number alone is seconds.
pub fn parse_seconds(text: &str) -> Result<Duration, String> {
    let bad = || format!("`{text}` is no length of time; write a number with s, ms or m, such as 60s");
    let text = text.trim();
    let units = [("ms", 1e-3), ("s", 1.0), ("m", 60.0)];
    let unit = units.into_iter().find_map(|(unit, factor)| Some((text.strip_suffix(unit)?, factor)));
    let (number, factor) = unit.unwrap_or((text, 1.0));
    let digits = !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    let number: f64 = if digits { number.parse().map_err(|_| bad())? } else { return Err(bad()) };
    // A day is more than anybody waits.
    let most = 86_400.0;
    if factor * number > most {
        return Err(format!("`{text}` is more than a day"));
    }
    Ok(Duration::from_secs_f64(factor * number))
}

/// The reading of `1000000`, `1M`, `10k`, `2.5M`: decimal multiples, as things are counted.
pub fn parse_count(text: &str) -> Result<u64, String> {
    let bad = || format!("`{text}` is not a count; write a whole number or a number with k, M or G, such as 10k or 1M");
    let text = text.trim();
    let (number, zeros) = match text.char_indices().next_back().ok_or_else(bad)? {
        (i, 'k' | 'K') => (&text[..i], 3),
        (i, 'm' | 'M') => (&text[..i], 6),
        (i, 'g' | 'G') => (&text[..i], 9),
        _ => (text, 0),
    };
    let (whole, fraction) = number.split_once('.').unwrap_or((number, ""));
    let digits = |s: &str| s.bytes().all(|b| b.is_ascii_digit());
    if whole.is_empty() || !digits(whole) || !digits(fraction) || fraction.len() > zeros {
        return Err(bad());
    }
    let padding = "0".repeat(zeros - fraction.len());
    format!("{whole}{fraction}{padding}").parse().map_err(|_| bad())
}

/// A number of rays up to a million, which a command takes into memory.
pub fn parse_rays(text: &str) -> Result<u32, String> {
    match parse_count(text)? {
        count @ 0..=1_000_000 => Ok(count as u32),
        _ => Err("a million rays is the most".to_string()),
    }
}

/// A number of threads; starting more than any machine has would only exhaust the system.
pub fn parse_jobs(text: &str) -> Result<usize, String> {
    const MOST: usize = Executor::MOST_THREADS;
    let jobs = text.parse().ok().filter(|n| *n <= MOST);
    jobs.ok_or_else(|| format!("`{text}` is not a number of threads from 0 to {MOST}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_grouped_by_thousands() {
        assert_eq!(count(0u32), "0");
        assert_eq!(count(999u32), "999");
        assert_eq!(count(69_451u32), "69,451");
        assert_eq!(count(u64::MAX), "18,446,744,073,709,551,615");
    }

    #[test]
    fn counts_are_read_as_people_write_them() {
        assert_eq!(parse_count("0"), Ok(0));
        assert_eq!(parse_count("10k"), Ok(10_000));
        assert_eq!(parse_count("1M"), Ok(1_000_000));
        assert_eq!(parse_count("2.5M"), Ok(2_500_000));
        for bad in ["", "M", "-1", "1.5", "1.2345k", "1e6", "99999999999G"] {
            assert!(parse_count(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn lengths_of_time_are_read_as_people_write_them() {
        let of = |text| parse_seconds(text).map(|d| d.as_millis());
        assert_eq!([of("60s"), of("500ms"), of("2m"), of("1.5"), of("0s")], [60_000, 500, 120_000, 1500, 0].map(Ok));
        for bad in ["", "s", "-1s", "1e3s", "inf", "nan", "1.2.3s", "2000m", "5h"] {
            assert!(parse_seconds(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn sizes_are_read_as_people_write_them() {
        assert_eq!(parse_size("1048576"), Ok(1 << 20));
        assert_eq!(parse_size("512M"), Ok(512 << 20));
        assert_eq!(parse_size("8GiB"), Ok(8 << 30));
        assert!(parse_size("").is_err() && parse_size("M").is_err() && parse_size("-1").is_err());
        assert!(parse_size("99999999999T").is_err());
    }
}
