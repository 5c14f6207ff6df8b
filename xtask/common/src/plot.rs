//! Plots of curves as SVG, for embedding in a page: colours and fonts come from its style sheet (classes `plot`,
//! `curve`, `mark`, `grid`, `tick`, and `s1` to `s7` for the series).

use maud::{Markup, html};
use mesh_render::ticks;

/// Curves over common axes.
#[derive(Clone, Debug)]
pub struct Plot {
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The curves, in the order of the legend.
    pub series: Vec<Series>,
}

/// Label and scale of an axis.
#[derive(Clone, Debug)]
pub struct Axis {
    /// The quantity and its unit.
    pub label: String,
    /// Whether the scale is logarithmic. Then all values have to be positive.
    pub log: bool,
}

/// One curve, marked at its points.
#[derive(Clone, Debug)]
pub struct Series {
    /// The name in the legend.
    pub name: String,
    /// The points, joined in this order.
    pub points: Vec<[f64; 2]>,
    /// For curves for comparison, such as curves of other tools.
    pub dashed: bool,
}

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 430.0;
/// The style of a plot outside a page.
const STYLE: &str = "\
    .paper { fill: #fff; } \
    text { fill: #1c2128; font: 13px system-ui, sans-serif; } .tick { fill: #59626e; font-size: 12px; } \
    .grid { stroke: #dde2e8; } .frame { stroke: #59626e; fill: none; } \
    .curve { fill: none; stroke-width: 2; } \
    .s1 { stroke: #2f6fd0; } .s2 { stroke: #d1622b; } .s3 { stroke: #2c8f5a; } \
    .s4 { stroke: #8a4fc7; } .s5 { stroke: #b8325a; } .s6 { stroke: #6f7782; } .s7 { stroke: #1c2128; } \
    .mark.s1 { fill: #2f6fd0; } .mark.s2 { fill: #d1622b; } .mark.s3 { fill: #2c8f5a; } \
    .mark.s4 { fill: #8a4fc7; } .mark.s5 { fill: #b8325a; } .mark.s6 { fill: #6f7782; } \
    .mark.s7 { fill: #1c2128; }";
/// Room for labels around the frame.
const LEFT: f64 = 84.0;
const RIGHT: f64 = 20.0;
const TOP: f64 = 16.0;
const BOTTOM: f64 = 62.0;
/// Height of a line of the legend, and the largest width of a letter.
const LINE: f64 = 20.0;
const LETTER: f64 = 7.4;

impl Axis {
    /// A linear axis.
    #[must_use]
    pub fn linear(label: &str) -> Self {
        Self { label: label.into(), log: false }
    }

    /// A logarithmic axis.
    #[must_use]
    pub fn log(label: &str) -> Self {
        Self { label: label.into(), log: true }
    }
}

impl Series {
    /// A solid curve.
    #[must_use]
    pub fn new(name: &str, points: Vec<[f64; 2]>) -> Self {
        Self { name: name.into(), points, dashed: false }
    }
}

impl Plot {
    /// The plot as an SVG element.
    pub fn svg(&self) -> String {
        self.markup().into_string()
    }

    /// The plot as an SVG file with its own style.
    pub fn file(&self) -> String {
        let head = format!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" class="plot""#
        );
        let body = self.svg().replacen(r#"<svg class="plot""#, &head, 1);
        let inside =
            format!(r#"><style>{STYLE}</style><rect class="paper" width="100%" height="100%"/>"#);
        body.replacen('>', &inside, 1)
    }

    fn markup(&self) -> Markup {
        let legend_lines = self.legend_lines();
        let top = TOP + LINE * legend_lines.len() as f64;
        let x = Scale::new(&self.x, self.values(0), LEFT, WIDTH - RIGHT);
        let y = Scale::new(&self.y, self.values(1), HEIGHT - BOTTOM, top);
        let label = format!("{} against {}", self.y.label, self.x.label);
        let (middle_x, middle_y) = (0.5 * (x.from + x.to), 0.5 * (y.from + y.to));
        html! {
            svg.plot viewBox={ "0 0 " (WIDTH) " " (HEIGHT) } role="img" aria-label=(label) {
                @for tick in x.ticks() {
                    @let at = round(x.place(tick));
                    line.grid x1=(at) x2=(at) y1=(y.from) y2=(y.to) {}
                    text.tick x=(at) y=(y.from + 18.0) text-anchor="middle" { (tick_text(tick)) }
                }
                @for tick in y.ticks() {
                    @let at = round(y.place(tick));
                    line.grid x1=(x.from) x2=(x.to) y1=(at) y2=(at) {}
                    text.tick x=(x.from - 8.0) y=(at + 4.0) text-anchor="end" { (tick_text(tick)) }
                }
                rect.frame x=(x.from) y=(y.to) width=(x.to - x.from) height=(y.from - y.to) {}
                text x=(middle_x) y=(HEIGHT - 14.0) text-anchor="middle" { (self.x.label) }
                text x="18" y=(middle_y) text-anchor="middle" transform={ "rotate(-90 18 " (middle_y) ")" } { (self.y.label) }
                @for (i, series) in self.series.iter().enumerate() { (curve(series, i, &x, &y)) }
                (legend(&legend_lines))
            }
        }
    }

    fn values(&self, axis: usize) -> impl Iterator<Item = f64> {
        self.series.iter().flat_map(|s| &s.points).map(move |p| p[axis])
    }

    /// The names of the series, broken into lines.
    fn legend_lines(&self) -> Vec<Vec<(usize, &Series, f64)>> {
        let mut lines: Vec<Vec<(usize, &Series, f64)>> = Vec::new();
        let mut end = f64::INFINITY;
        for (i, series) in self.series.iter().enumerate() {
            let width = 40.0 + LETTER * series.name.chars().count() as f64;
            if end + width > WIDTH - RIGHT {
                lines.push(Vec::new());
                end = LEFT;
            }
            if let Some(line) = lines.last_mut() {
                line.push((i, series, end));
            }
            end += width;
        }
        lines
    }
}

fn style_class(index: usize) -> String {
    format!("s{}", index % 7 + 1)
}

fn dashes(series: &Series) -> Option<&'static str> {
    series.dashed.then_some("5 4")
}

fn curve(series: &Series, index: usize, x: &Scale, y: &Scale) -> Markup {
    let places: Vec<[f64; 2]> =
        series.points.iter().map(|p| [round(x.place(p[0])), round(y.place(p[1]))]).collect();
    let line: Vec<String> = places.iter().map(|[x, y]| format!("{x},{y}")).collect();
    let class = style_class(index);
    html! {
        polyline class={ "curve " (class) } points=(line.join(" ")) stroke-dasharray=[dashes(series)] {}
        @for [x, y] in &places { circle class={ "mark " (class) } cx=(x) cy=(y) r="3.2" {} }
    }
}

fn legend(lines: &[Vec<(usize, &Series, f64)>]) -> Markup {
    html! {
        @for (row, line) in lines.iter().enumerate() {
            @let y = TOP + LINE * row as f64;
            @for (index, series, x) in line {
                @let class = style_class(*index);
                line class={ "curve " (class) } x1=(x) x2=(x + 24.0) y1=(y) y2=(y) stroke-dasharray=[dashes(series)] {}
                circle class={ "mark " (class) } cx=(x + 12.0) cy=(y) r="3.2" {}
                text x=(x + 30.0) y=(y + 4.5) { (series.name) }
            }
        }
    }
}

/// Maps values to places in the picture.
struct Scale {
    low: f64,
    high: f64,
    log: bool,
    from: f64,
    to: f64,
}

impl Scale {
    /// Maps the range of the values, slightly enlarged, to the places `from` to `to`.
    fn new(axis: &Axis, values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let unit = |x: f64| if axis.log { x.log10() } else { x };
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.map(unit).filter(|x| x.is_finite()) {
            (low, high) = (low.min(value), high.max(value));
        }
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        let room = if high > low { 0.05 * (high - low) } else { 0.5 };
        let starts_at_zero = !axis.log && low >= 0.0 && low < 0.4 * high;
        let low = if starts_at_zero { 0.0 } else { low - room };
        Self { low, high: high + room, log: axis.log, from, to }
    }

    fn place(&self, value: f64) -> f64 {
        let value = if self.log { value.log10() } else { value };
        self.from + (value - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// Round values in the range.
    fn ticks(&self) -> Vec<f64> {
        if self.log {
            ticks::log(10_f64.powf(self.low), 10_f64.powf(self.high))
        } else {
            ticks::linear(self.low, self.high, 6)
        }
    }
}

fn round(x: f64) -> f64 {
    (x * 10.0).round() / 10.0
}

fn tick_text(tick: f64) -> String {
    // Steps of a linear axis accumulate rounding errors.
    let rounded: f64 = format!("{tick:.6e}").parse().unwrap_or(tick);
    if rounded.abs() >= 1000.0 {
        return super::decimals::plain(rounded);
    }
    if rounded != 0.0 && rounded.abs() < 1e-4 {
        return format!("{rounded:e}");
    }
    rounded.to_string()
}

#[cfg(test)]
mod tests {
    use super::{Axis, Plot, Scale, Series, tick_text};

    #[test]
    fn ticks_are_round_and_inside() {
        let scale = Scale::new(&Axis::linear("x"), [0.0, 0.53].into_iter(), 0.0, 100.0);
        let ticks: Vec<String> = scale.ticks().into_iter().map(tick_text).collect();
        assert_eq!(ticks, ["0", "0.1", "0.2", "0.3", "0.4", "0.5"]);
        let scale = Scale::new(&Axis::log("x"), [0.003, 0.9].into_iter(), 0.0, 100.0);
        let ticks: Vec<String> = scale.ticks().into_iter().map(tick_text).collect();
        assert_eq!(ticks, ["0.005", "0.01", "0.02", "0.05", "0.1", "0.2", "0.5", "1"]);
        assert_eq!(tick_text(20_000.0), "20,000");
    }

    #[test]
    fn points_stay_inside_the_frame_and_text_is_escaped() {
        let plot = Plot {
            x: Axis::log("faces"),
            y: Axis::linear("error <%>"),
            series: vec![Series::new("a & b", vec![[10.0, 1.0], [1000.0, 5.0]])],
        };
        let svg = plot.svg();
        assert!(svg.contains("a &amp; b") && svg.contains("error &lt;%&gt;"));
        assert!(!svg.contains("NaN"));
        let file = plot.file();
        assert!(file.starts_with("<svg xmlns") && file.matches("<style>").count() == 1);
        assert!(file.len() > svg.len() && file.ends_with("</svg>"));
    }

    #[test]
    fn a_single_value_has_a_place() {
        let scale = Scale::new(&Axis::linear("x"), [7.0].into_iter(), 0.0, 100.0);
        assert!((scale.place(7.0) - 50.0).abs() < 1e-9);
    }
}
