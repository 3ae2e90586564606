//! The body as far as the layout knows it: its sensors and points, and the arrow of the hit that is wanted.

use massline_shared::layout::RigLayout;
use nalgebra::{Vector2, Vector3};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::symbols::Marker;
use ratatui::text::Span;
use ratatui::widgets::canvas::{Canvas, Context, Line, Points};

use super::framed;
use crate::screen::Theme;
use crate::screen::guide::Guide;
use massline_report::projection::across;

/// Fewest rows, with the frame.
pub(super) const LOWEST: u16 = 6;
/// Length of the arrow and of the axes over the size of the body.
const ARROW: f64 = 0.35;
const AXES: f64 = 0.2;
/// The head of the arrow over its length.
const HEAD: f64 = 0.3;

/// The body with the point and the arrow of the DOF in hand.
pub(super) fn body(guide: &Guide, frame: &mut Frame<'_>, area: Rect, theme: Theme) {
    let block = framed(" arrow: force on the body ", theme);
    let inner = block.inner(area);
    let sketch = Sketch::of(guide, theme);
    let [x, y] = sketch.bounds(inner);
    let canvas = Canvas::default()
        .block(block)
        .marker(Marker::Braille)
        .x_bounds(x)
        .y_bounds(y)
        .paint(|context| sketch.paint(context));
    frame.render_widget(canvas, area);
}

struct Sketch<'g> {
    layout: &'g RigLayout,
    theme: Theme,
    /// The point that is hit and the two ends of its arrow, and its name.
    hit: Option<(Vector2<f64>, Vector2<f64>, String)>,
    /// Where the axes of the body frame begin, and how long they are.
    origin: Vector3<f64>,
    axis: f64,
}

impl<'g> Sketch<'g> {
    fn of(guide: &'g Guide, theme: Theme) -> Self {
        let layout = &guide.layout;
        let points: Vec<Vector3<f64>> = positions(layout).collect();
        let start = points.first().copied().unwrap_or_default();
        let low = points.iter().fold(start, |a, b| a.inf(b));
        let high = points.iter().fold(start, |a, b| a.sup(b));
        let size = (high - low).norm().max(1e-3);
        let hit = guide.dof().map(|hit| {
            let [at, along] =
                [hit.position, hit.direction].map(|v| Vector3::from(v.map(f64::from)));
            let tail = at - along * (ARROW * size);
            (across() * at, across() * tail, hit.dof.to_string())
        });
        Self { layout, theme, hit, origin: low, axis: AXES * size }
    }

    /// Limits of the plane, so that a length is as long to the right as it is up.
    fn bounds(&self, area: Rect) -> [[f64; 2]; 2] {
        let ends = self.hit.iter().flat_map(|(at, tail, _)| [*at, *tail]);
        let axes = Vector3::from_element(self.axis);
        let axes = (0..3).map(|k| self.origin + axes.component_mul(&unit(k)));
        let points: Vec<Vector2<f64>> =
            positions(self.layout).chain(axes).map(|p| across() * p).chain(ends).collect();
        let start = points.first().copied().unwrap_or_default();
        let low = points.iter().fold(start, |a, b| a.inf(b));
        let high = points.iter().fold(start, |a, b| a.sup(b));
        // A cell has two dots across and four up, and room for a label at either side.
        let dots = [area.width.saturating_sub(8) * 2, area.height.saturating_sub(2) * 4];
        let [wide, tall] = dots.map(|dots| f64::from(dots.max(1)));
        let scale = ((high.x - low.x) / wide).max((high.y - low.y) / tall).max(1e-6);
        let middle = (low + high) / 2.0;
        let [across, up] =
            [area.width * 2, area.height * 4].map(|dots| f64::from(dots) * scale / 2.0);
        [[middle.x - across, middle.x + across], [middle.y - up, middle.y + up]]
    }

    fn paint(&self, context: &mut Context<'_>) {
        for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
            let end = across() * (self.origin + unit(k) * self.axis);
            line(context, across() * self.origin, end, self.theme.faint());
            context.print(end.x, end.y, Span::styled(name, self.theme.faint()));
        }
        let sensors: Vec<Vector3<f64>> =
            self.layout.sensors.iter().map(|sensor| in_m(sensor.position)).collect();
        for (place, from) in sensors.iter().enumerate() {
            for to in &sensors[place + 1..] {
                line(context, across() * from, across() * to, self.theme.faint());
            }
        }
        let spots: Vec<(f64, f64)> = self
            .layout
            .hits
            .iter()
            .map(|hit| across() * in_m(hit.position))
            .map(|at| (at.x, at.y))
            .collect();
        let color = self.theme.faint().fg.unwrap_or_default();
        context.draw(&Points { coords: &spots, color });
        context.layer();
        for (sensor, at) in self.layout.sensors.iter().zip(&sensors) {
            let at = across() * at;
            context.print(
                at.x,
                at.y,
                Span::styled(format!("▣{}", sensor.node), self.theme.strong()),
            );
        }
        if let Some((at, tail, name)) = &self.hit {
            self.arrow(context, *at, *tail);
            context.layer();
            context.print(tail.x, tail.y, Span::styled(name.clone(), self.theme.accent()));
        }
    }

    /// From the tail to the point that is hit. An arrow along the view is a cross.
    fn arrow(&self, context: &mut Context<'_>, at: Vector2<f64>, tail: Vector2<f64>) {
        let style = self.theme.accent();
        let back = (tail - at) * HEAD;
        let side = Vector2::new(-back.y, back.x) * 0.5;
        line(context, tail, at, style);
        line(context, at, at + back + side, style);
        line(context, at, at + back - side, style);
    }
}

fn line(context: &mut Context<'_>, from: Vector2<f64>, to: Vector2<f64>, style: Style) {
    let color = style.fg.unwrap_or_default();
    context.draw(&Line { x1: from.x, y1: from.y, x2: to.x, y2: to.y, color });
}

fn unit(axis: usize) -> Vector3<f64> {
    Vector3::from_fn(|k, _| if k == axis { 1.0 } else { 0.0 })
}

fn in_m(position: [f32; 3]) -> Vector3<f64> {
    Vector3::from(position.map(f64::from))
}

/// All points of the body that the layout names.
fn positions(layout: &RigLayout) -> impl Iterator<Item = Vector3<f64>> {
    let sensors = layout.sensors.iter().map(|sensor| sensor.position);
    sensors.chain(layout.hits.iter().map(|hit| hit.position)).map(in_m)
}
