//! What can be typed after `bvhc view`, and how it is read.

use crate::cli::Context;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::frame_list::FrameList;
use crate::cli::names;
use crate::report::picture::{Shade, Standpoint};
use crate::trace::probe::Camera;
use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};
use std::io::IsTerminal;
use std::path::PathBuf;

/// Show a file: a picture of the scene or of what its tree costs, or an outline of the tree
///
/// Each pixel is one ray through the file's own trees. Heat is counted and not timed, so a picture is the same on every machine.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    bvhc view rock.bvhc -o rock.png                      the scene\n  \
    bvhc view rock.bvhc -o heat.png --shade visits       inner nodes that each pixel's ray visits\n  \
    bvhc view rock.bvhc -o boxes.png --boxes 4           the boxes of level 4 over it\n  \
    bvhc view --compare a.bvhc b.bvhc -o both.png        two trees of one model, and where they differ\n  \
    bvhc view rock.bvhc --html rock.html                 a page to fly through the scene and its tree\n  \
    bvhc view caches/ -o pictures/                       a picture of each file in a folder\n  \
    bvhc view heli.bvhc -o heli.%04d.png --frame all     a picture of each frame\n  \
    bvhc view rock.bvhc                                  the same page, in a browser at once\n  \
    bvhc view rock.bvhc --terminal                       in the terminal\n  \
    bvhc view rock.bvhc --tree --depth 3                 the upper levels of the tree")]
pub struct ViewArgs {
    /// Cache files, folders of them, or quoted patterns such as 'caches/**/*.bvhc'; two files with --compare
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Write the picture as PNG; a folder (`DIR/`) receives one for each file, and a name with a place for the number, such as heli.%04d.png, one for each frame
    #[arg(short, long, value_name = "PNG", conflicts_with = "tree")]
    pub output: Option<PathBuf>,
    /// Write a page that carries the trees with it and traces them in the browser: fly, see costs, follow a ray, compare two trees. Of a sequence all frames, or
    /// those that --frame names. A folder (`DIR/`) receives a page for each file
    #[arg(long, value_name = "HTML", conflicts_with_all = ["output", "tree", "terminal", "shade", "size", "samples", "scale", "boxes"])]
    pub html: Option<PathBuf>,
    /// Serve that page to a browser on this machine, and start one; so does a run in a terminal that asks for nothing else
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = "0", conflicts_with_all = ["output", "html", "tree", "terminal", "json", "shade", "size", "samples", "scale", "boxes"])]
    pub serve: Option<u16>,
    /// Start no browser; the address of the page is printed
    #[arg(long, conflicts_with_all = ["output", "html", "tree", "terminal", "json"])]
    pub no_browser: bool,
    /// Show the picture in the terminal: in full colour, 256 colours or plain letters, as it can
    #[arg(long, conflicts_with_all = ["tree", "json"])]
    pub terminal: bool,
    /// Print the nodes of the upper levels: box, shares of area and SAH, references
    #[arg(long, conflicts_with_all = ["shade", "camera", "up", "size", "samples", "scale", "boxes", "compare"])]
    pub tree: bool,
    /// With --tree: levels below the first node
    #[arg(long, value_name = "N", default_value_t = 4, requires = "tree", value_parser = clap::value_parser!(u32).range(..=64))]
    pub depth: u32,
    /// What the colours show [default: lit, with --compare cost]
    #[arg(long, value_name = "WHAT", value_enum)]
    pub shade: Option<Shade>,
    /// Where from: auto, inside, outside, front, back, left, right, top, bottom; or eye, target and the angle of view across the longer side in degrees as
    /// x,y,z,x,y,z,angle. `auto` stands where most of the triangles are seen
    #[arg(long, value_name = "WHERE", default_value = "auto", value_parser = parse_stand, allow_hyphen_values = true)]
    pub camera: Stand,
    /// The axis that points up
    #[arg(long, value_name = "AXIS", value_enum, default_value = "y")]
    pub up: Up,
    /// Pixels of the picture across and down; what its colours stand for is drawn below it [default: 1280x800; in the terminal 80x44]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<Film>,
    /// Rays for each pixel, across and down: 3 makes smooth edges by nine rays
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=8))]
    pub samples: u8,
    /// What the brightest colour stands for [default: a round number that 49 of 50 pixels do not exceed]
    #[arg(long, value_name = "N", value_parser = parse_most)]
    pub scale: Option<f64>,
    /// Draw the boxes of the nodes on this level, and of leaves above it; the root is on level 0
    #[arg(long, value_name = "LEVEL", value_parser = clap::value_parser!(u32).range(..=130))]
    pub boxes: Option<u32>,
    /// Show only what is below this node, a number from --tree; of a file of two levels its tree alone, in its own space
    #[arg(long, value_name = "NODE")]
    pub root: Option<u64>,
    /// Of a sequence: the frames to show: one number, a list such as 1-100 or 1,5-9, or all. The camera stands still, where the first of them is seen
    #[arg(long, value_name = "all|LIST", allow_hyphen_values = true, value_parser = FrameList::parse)]
    pub frame: Option<FrameList>,
    /// Two files of one model: left, right and the difference, with one scale
    #[arg(long, conflicts_with = "root")]
    pub compare: bool,
}

/// Where a picture is taken from.
#[derive(Clone, Copy, Debug)]
pub enum Stand {
    /// By name.
    Named(Standpoint),
    /// As it was typed; which way is up is another flag's.
    Typed(Camera),
}

/// Pixels across and down.
#[derive(Clone, Copy, Debug)]
pub struct Film {
    pub width: usize,
    pub height: usize,
}

/// An axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Up {
    X,
    Y,
    Z,
}

impl ViewArgs {
    /// What the colours show.
    pub fn shade(&self) -> Shade {
        self.shade.unwrap_or(if self.compare { Shade::Cost } else { Shade::Lit })
    }

    /// Refuse a scale where colours stand for no numbers.
    pub fn suits(&self) -> Result<(), Failure> {
        if self.scale.is_none() || self.shade().counted().is_some() {
            return Ok(());
        }
        Err(Failure::new(Exit::Usage, "cannot draw with --scale")
            .fact(format!("with --shade {} the colours stand for no numbers", self.shade().name()))
            .help("leave out --scale, or count something, such as --shade cost"))
    }

    /// On which port to serve a page, where that is asked for: by the flag, or by a person at a terminal who says nothing of where the picture goes. 0 is any.
    pub fn port(&self, says_nothing: bool, context: &Context) -> Option<u16> {
        let is_watched = says_nothing && !context.terminal.json && std::io::stdout().is_terminal();
        let wants_a_picture =
            self.shade.is_some() || self.size.is_some() || self.scale.is_some() || self.boxes.is_some();
        self.serve.or((is_watched && !wants_a_picture).then_some(0))
    }
}

impl Up {
    pub fn axis(self) -> usize {
        self as usize
    }
}

impl ValueEnum for Shade {
    fn value_variants<'a>() -> &'a [Shade] {
        &Shade::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let about = match self {
            Shade::Lit => "The surface in the light of a lamp",
            Shade::Normal => "Which way the surface faces: red, green and blue for x, y and z",
            Shade::Part => "A colour for each part of the source",
            Shade::Instance => "A colour for each instance",
            Shade::Depth => "How deep the leaf lies that was hit",
            Shade::Visits => "Inner nodes that the ray visits",
            Shade::Tests => "Triangles that the ray is tested with",
            Shade::Cost => "Both, as the SAH counts them: 1.2 · nodes + triangles",
        };
        Some(PossibleValue::new(self.name()).help(about))
    }
}

/// The widest angle of view that a flat film can have, and still be looked at.
const WIDEST: f64 = 170.0;

fn parse_stand(text: &str) -> Result<Stand, String> {
    if let Some(named) = Standpoint::ALL.into_iter().find(|s| s.name() == text) {
        return Ok(Stand::Named(named));
    }
    let names = Standpoint::ALL.map(Standpoint::name).join(", ");
    let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    let numbers: Option<[f64; 7]> = numbers.and_then(|all| all.try_into().ok());
    let Some([x, y, z, to_x, to_y, to_z, angle]) = numbers.filter(|all| all.iter().all(|n| n.abs() < 1e30)) else {
        return Err(format!("`{}` is neither one of {names} nor seven numbers x,y,z,x,y,z,angle", names::escape(text)));
    };
    if !(angle > 0.0 && angle <= WIDEST) {
        return Err(format!("an angle of view of {angle} degrees cannot be shown; it is above 0 and at most {WIDEST}"));
    }
    let (eye, look_at) = ([x, y, z], [to_x, to_y, to_z]);
    if eye == look_at {
        return Err("eye and target are one point, so there is no direction to look in".to_string());
    }
    Ok(Stand::Typed(Camera { eye, look_at, up: [0.0; 3], tan_half: (angle / 2.0).to_radians().tan() }))
}

/// The longest side of a picture, and the most pixels of one: what a shot of them holds stays below a few gigabytes.
const LONGEST: usize = 16_384;
const MOST_PIXELS: usize = 1 << 26;

fn parse_size(text: &str) -> Result<Film, String> {
    let bad = || format!("`{}` is no size; write pixels across and down, such as 1280x800", names::escape(text));
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(bad)?;
    let side = |text: &str| text.parse::<usize>().map_err(|_| bad());
    let (width, height) = (side(width)?, side(height)?);
    let fits = |side| (1..=LONGEST).contains(&side);
    if !fits(width) || !fits(height) || width * height > MOST_PIXELS {
        return Err(format!(
            "{width}x{height} is no size of a picture: sides are 1 to {LONGEST}, and at most {MOST_PIXELS} pixels"
        ));
    }
    Ok(Film { width, height })
}

fn parse_most(text: &str) -> Result<f64, String> {
    let most = text.parse::<f64>().ok().filter(|n| *n > 0.0 && *n <= 1e12);
    most.ok_or_else(|| format!("`{}` is no end of a scale, which is a number above 0", names::escape(text)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_are_read_by_name_and_by_numbers() {
        assert!(matches!(parse_stand("inside"), Ok(Stand::Named(Standpoint::Inside))));
        let Ok(Stand::Typed(camera)) = parse_stand("0,1,-2.5, 3,4,5, 90") else { panic!("seven numbers") };
        assert_eq!((camera.eye, camera.look_at), ([0.0, 1.0, -2.5], [3.0, 4.0, 5.0]));
        assert!((camera.tan_half - 1.0).abs() < 1e-12);
        for bad in ["", "nowhere", "1,2,3", "0,0,0,0,0,0,60", "0,0,0,1,0,0,0", "0,0,0,1,0,0,180", "nan,0,0,1,0,0,60"] {
            assert!(parse_stand(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn sizes_have_bounds() {
        assert!(parse_size("640x480").is_ok_and(|film| (film.width, film.height) == (640, 480)));
        for bad in ["640", "0x5", "5x0", "-1x5", "16385x1", "16384x16384", "axb"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
        assert!(parse_most("0").is_err() && parse_most("nan").is_err() && parse_most("12.5") == Ok(12.5));
    }
}
