use super::scale::{Fit, Scale, short};
use super::*;

#[test]
fn the_front_holds_what_nothing_beats() {
    let point = |x, y, name: &str| Point::new(x, y).named(name);
    let points = vec![
        point(1.0, 9.0, "fast"),
        point(2.0, 9.0, "worse"),
        point(3.0, 4.0, "middle"),
        point(3.0, 5.0, "beaten at the same x"),
        point(9.0, 4.0, "slower for nothing"),
        point(8.0, 1.0, "good"),
        point(f64::NAN, 0.0, "not drawn"),
    ];
    let (x, y) = (Axis::linear("time").lower_is_better(), Axis::linear("cost").lower_is_better());
    let panel = Panel::new("", x.clone(), y).with(Series::new("", 0, points.clone()));
    let names = |panel: &Panel| front::of(panel).iter().map(|p| p.label.clone()).collect::<Vec<_>>();
    assert_eq!(names(&panel), ["fast", "middle", "good"]);

    let upward = Panel::new("", x, Axis::linear("rate")).with(Series::new("", 0, points));
    assert_eq!(names(&upward), ["fast"]);
}

#[test]
fn axes_have_round_numbers_and_a_place_for_zero() {
    let linear = Fit::new(Scale::Linear, [12.0, 47.3].into_iter());
    assert_eq!(linear.ticks(), [0.0, 10.0, 20.0, 30.0, 40.0, 50.0]);
    assert_eq!((linear.position(0.0), linear.position(51.084) > 0.99), (0.0, true));

    let logarithmic = Fit::new(Scale::Logarithmic, [3.0, 300.0, -1.0, 0.0].into_iter());
    assert_eq!(logarithmic.ticks(), [5.0, 10.0, 20.0, 50.0, 100.0, 200.0]);
    assert!(logarithmic.position(3.0) > 0.0 && logarithmic.position(300.0) < 1.0);

    let or_zero = Fit::new(Scale::LogarithmicOrZero, [0.0, 10.0, 1e5].into_iter());
    assert_eq!(or_zero.ticks(), [0.0, 10.0, 100.0, 1e3, 1e4, 1e5]);
    assert!(or_zero.position(0.0) > 0.0 && or_zero.position(0.0) < or_zero.position(10.0));
    assert_eq!(Fit::new(Scale::Logarithmic, std::iter::empty()).ticks(), [1.0, 2.0, 5.0, 10.0]);
    let close = Fit::new(Scale::Close, [10.7, 12.4, 0.0].into_iter());
    assert_eq!(close.ticks(), [11.0, 11.5, 12.0, 12.5]);
    assert!(close.position(10.7) < 0.1 && close.position(12.4) > 0.9);
    let narrow = Fit::new(Scale::Logarithmic, [0.41, 0.52].into_iter());
    assert!(narrow.ticks().len() >= 3, "{:?}", narrow.ticks());
}

#[test]
fn numbers_are_short() {
    let texts = [0.0, 0.05, 2.5, 50.0, 5000.0, 20_000.0, 108_642.0, 1.5e6, 1e-6].map(short);
    assert_eq!(texts, ["0", "0.05", "2.5", "50", "5000", "20k", "109k", "1.5M", "1e-6"]);
}

#[test]
fn names_keep_off_each_other() {
    let frame = [0.0, 0.0, 200.0, 100.0];
    let at = [[100.0, 50.0], [104.0, 50.0], [100.0, 54.0], [195.0, 50.0]];
    let mut places = labels::Places::new(frame, at.into_iter(), 4.0);
    let found: Vec<[f64; 2]> = at.iter().map(|p| places.find(*p, "name", 10.0)).collect();
    let w = labels::width("name", 10.0);
    for (i, a) in found.iter().enumerate() {
        assert!(a[0] >= 0.0 && a[0] + w <= 200.0, "{a:?} leaves the frame");
        for b in &found[..i] {
            let apart = (a[0] - b[0]).abs() >= w || (a[1] - b[1]).abs() >= 10.0;
            assert!(apart, "{a:?} covers {b:?}");
        }
    }
}

#[test]
fn names_keep_off_lines() {
    // A front that goes through the points from the upper left to the lower right, and a spread to the right of the last.
    let points = [[1.0, 9.0], [3.0, 5.0], [6.0, 2.0], [9.0, 1.0]];
    let named = points.iter().enumerate().map(|(i, [x, y])| Point::new(*x, *y).named(format!("name {i}")));
    let mut named: Vec<Point> = named.collect();
    named[1] = named[1].clone().spread([2.5, 5.0]);
    let axis = |label: &str| Axis::linear(label).lower_is_better();
    let panel = Panel::new("", axis("x"), axis("y")).with_front().with(Series::new("", 0, named.clone()));
    let at = |p: &Point| [40.0 * p.x, 400.0 - 40.0 * p.y];
    let mut places = labels::Places::of(&panel, [0.0, 0.0, 400.0, 400.0], &at, 4.0);
    let front: Vec<[f64; 2]> = panel.best().into_iter().map(at).collect();
    assert_eq!(front.len(), 4);
    let lines: Vec<[[f64; 2]; 2]> =
        front.windows(2).map(|pair| [pair[0], pair[1]]).chain([[[100.0, 200.0], [200.0, 200.0]]]).collect();
    for point in &named {
        let [left, middle] = places.find(at(point), &point.label, 11.0);
        let right = left + labels::width(&point.label, 11.0);
        for [a, b] in &lines {
            for i in 0..=1000 {
                let share = f64::from(i) / 1000.0;
                let [x, y] = [0, 1].map(|k| a[k] + share * (b[k] - a[k]));
                let struck = x > left && x < right && (y - middle).abs() < 5.5;
                assert!(!struck, "{} at {left}, {middle} is struck through at {x}, {y}", point.label);
            }
        }
    }
}

#[test]
fn a_chart_shows_every_point_and_escapes_text() {
    let points = vec![Point::new(1.0, 0.0).named("<a & b>"), Point::new(10.0, 5.0).marked(Marker::Square)];
    let panel = Panel::new("scene", Axis::logarithmic("speed"), Axis::logarithmic_or_zero("errors").lower_is_better());
    let panel = panel.with(Series::new("method", 1, points).connected()).with_front();
    let chart = Chart {
        title: "title".into(),
        notes: vec!["a note".into()],
        panels: vec![panel.clone(), panel],
        columns: 2,
        markers: vec![(Marker::Square, "a square".into())],
    };
    let svg = chart.svg().expect("a chart");
    for text in ["title", "scene", "speed", "errors", "a note", "a square", "&lt;a &amp; b&gt;"] {
        assert!(svg.contains(text), "{text} is missing in {svg}");
    }
    // Two panels with a disc each and one in the legend; squares likewise.
    assert_eq!(svg.matches("<circle").count(), 3, "{svg}");
    assert_eq!(svg.matches(">\nmethod\n<").count(), 1, "{svg}");
    assert!(Chart::default().svg().is_ok());
}
