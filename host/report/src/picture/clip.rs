//! Cuts curves at the frame of their panel, so that a value outside is not drawn as one at the edge.

/// A place in the plane of a panel: along, and up.
pub(super) type Place = (f64, f64);

/// The pieces of a curve inside a frame with these ranges; it breaks at values that are no numbers, and where it leaves
/// the frame.
pub(super) fn pieces(curve: &[Place], x: [f64; 2], y: [f64; 2]) -> Vec<Vec<Place>> {
    let mut pieces: Vec<Vec<Place>> = Vec::new();
    for ends in curve.windows(2) {
        let Some([from, to]) = inside([ends[0], ends[1]], x, y) else { continue };
        match pieces.last_mut().filter(|piece| piece.last() == Some(&from)) {
            Some(piece) => piece.push(to),
            None => pieces.push(vec![from, to]),
        }
    }
    pieces
}

/// The part of a straight line inside a frame, by the shares of its length at which it enters and leaves (Liang and
/// Barsky, A New Concept and Method for Line Clipping, 1984).
fn inside([from, to]: [Place; 2], x: [f64; 2], y: [f64; 2]) -> Option<[Place; 2]> {
    let step = (to.0 - from.0, to.1 - from.1);
    let (mut enters, mut leaves) = (0.0, 1.0);
    for (start, step, [low, high]) in [(from.0, step.0, x), (from.1, step.1, y)] {
        if !step.is_finite() {
            return None;
        }
        if step == 0.0 {
            if start < low || start > high {
                return None;
            }
            continue;
        }
        let [first, second] = [(low - start) / step, (high - start) / step];
        enters = f64::max(enters, first.min(second));
        leaves = f64::min(leaves, first.max(second));
    }
    let at = |share: f64| (from.0 + share * step.0, from.1 + share * step.1);
    let is_seen = enters < leaves && step != (0.0, 0.0);
    // Ends that are not cut stay as they are, so that pieces join.
    let [first, last] =
        [if enters > 0.0 { at(enters) } else { from }, if leaves < 1.0 { at(leaves) } else { to }];
    is_seen.then_some([first, last])
}

#[cfg(test)]
mod tests {
    use super::pieces;

    const FRAME: [[f64; 2]; 2] = [[0.0, 10.0], [-1.0, 1.0]];

    #[test]
    fn a_curve_inside_its_frame_is_one_piece() {
        let curve = [(0.0, 0.0), (5.0, 0.5), (5.0, 0.5), (10.0, -1.0)];
        assert_eq!(pieces(&curve, FRAME[0], FRAME[1]), [[curve[0], curve[1], curve[3]]]);
    }

    #[test]
    fn what_is_outside_is_cut_off_and_not_laid_on_the_edge() {
        let curve = [
            (-2.0, 0.0),
            (2.0, 0.0),
            (4.0, 2.0),
            (6.0, 2.0),
            (8.0, 0.0),
            (8.5, f64::NAN),
            (9.0, 0.0),
        ];
        let pieces_inside = pieces(&curve, FRAME[0], FRAME[1]);
        assert_eq!(
            pieces_inside,
            [vec![(0.0, 0.0), (2.0, 0.0), (3.0, 1.0)], vec![(7.0, 1.0), (8.0, 0.0)]]
        );
    }

    #[test]
    fn a_line_that_passes_the_frame_by_is_not_drawn() {
        assert!(pieces(&[(-1.0, 0.0), (1.0, 9.0)], FRAME[0], FRAME[1]).is_empty());
        assert!(pieces(&[(0.0, 2.0), (10.0, 2.0)], FRAME[0], FRAME[1]).is_empty());
        assert!(pieces(&[(0.0, -1e308), (10.0, 1e308)], FRAME[0], [-1e308, 1e308]).is_empty());
    }
}
