//! A ray as text that gives the same bits back: `ox,oy,oz,dx,dy,dz[,tmin,tmax]`.

use crate::geom::Ray;

/// Shortest decimal numbers that round to the ray's own.
pub fn write_ray(ray: &Ray) -> String {
    let mut numbers: Vec<f32> = ray.origin.into_iter().chain(ray.direction).collect();
    let open = ray.t_min.to_bits() == 0 && ray.t_max == f32::INFINITY;
    if !open {
        numbers.extend([ray.t_min, ray.t_max]);
    }
    numbers.into_iter().map(number).collect::<Vec<_>>().join(",")
}

fn number(v: f32) -> String {
    let text = format!("{v:?}");
    text.strip_suffix(".0").map(String::from).unwrap_or(text)
}

/// Read what [`write_ray`] writes. A number may also be the eight hexadecimal digits of its bits, `0x3f800000`.
///
/// # Errors
/// Says what is wrong with the text.
pub fn read_ray(text: &str) -> Result<Ray, String> {
    let numbers = text.split(',').map(|n| read_number(n.trim())).collect::<Result<Vec<f32>, String>>()?;
    let count = numbers.len();
    let (&[ox, oy, oz, dx, dy, dz], rest) = numbers.split_first_chunk::<6>().ok_or_else(|| wrong(count))?;
    let (t_min, t_max) = match rest {
        [] => (0.0, f32::INFINITY),
        &[t_min, t_max] => (t_min, t_max),
        _ => return Err(wrong(count)),
    };
    Ok(Ray { origin: [ox, oy, oz], direction: [dx, dy, dz], t_min, t_max })
}

fn wrong(count: usize) -> String {
    format!("a ray is six numbers, ox,oy,oz,dx,dy,dz, or eight with tmin,tmax; here are {count}")
}

fn read_number(text: &str) -> Result<f32, String> {
    if let Some(digits) = text.strip_prefix("0x") {
        let bits = u32::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 8);
        return bits.map(f32::from_bits).ok_or_else(|| format!("`{text}` is not eight hexadecimal digits"));
    }
    text.parse().map_err(|_| format!("`{text}` is not a number"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn bits(ray: &Ray) -> [u32; 8] {
        let [a, b, c] = ray.origin.map(f32::to_bits);
        let [d, e, f] = ray.direction.map(f32::to_bits);
        [a, b, c, d, e, f, ray.t_min.to_bits(), ray.t_max.to_bits()]
    }

    #[test]
    fn any_ray_comes_back_with_its_bits() {
        let mut random = Random::new(1);
        for _ in 0..20_000 {
            let mut any = || loop {
                let v = f32::from_bits(random.bits() as u32);
                if !v.is_nan() {
                    return v;
                }
            };
            let ray =
                Ray { origin: [0; 3].map(|_| any()), direction: [0; 3].map(|_| any()), t_min: any(), t_max: any() };
            assert_eq!(bits(&read_ray(&write_ray(&ray)).unwrap()), bits(&ray), "{}", write_ray(&ray));
        }
        let plain = Ray::new([1.0, -0.0, 0.1], [0.0, 1e-40, -1.0]);
        assert_eq!(write_ray(&plain), "1,-0,0.1,0,1e-40,-1");
        assert_eq!(bits(&read_ray("1, -0, 0.1, 0, 1e-40, 0xbf800000").unwrap()), bits(&plain));
        assert_eq!(write_ray(&plain.until(2.0)), "1,-0,0.1,0,1e-40,-1,0,2");
        let backward = Ray { t_min: -0.0, ..plain };
        assert_eq!(bits(&read_ray(&write_ray(&backward)).unwrap()), bits(&backward));
    }

    #[test]
    fn other_text_is_refused_with_what_is_wrong() {
        for (text, says) in [
            ("1,2,3", "here are 3"),
            ("1,2,3,4,5,6,7", "here are 7"),
            ("a,2,3,4,5,6", "`a`"),
            ("0x1,2,3,4,5,6", "`0x1`"),
        ] {
            assert!(read_ray(text).unwrap_err().contains(says), "{text}");
        }
    }
}
