//! Finished DOFs with their lines, as objects of the kind [`ObjectKind::Lines`].

use massline_shared::layout::RIG_HITS;
use massline_shared::signal::{COMPACT_RESPONSE, RESPONSES};
use serde::de::DeserializeOwned;

use crate::lines_head::LinesHead;
use crate::object::{ObjectId, ObjectKind};

/// Stands for the current campaign in [`LinesId::result`]. Results are counted from 1.
pub const CURRENT_CAMPAIGN: u32 = 0;

/// Numbers of objects for each result: more than a layout has DOFs.
const DOFS: u32 = 16;
const _: () = assert!(RIG_HITS <= DOFS as usize);

/// Identifies a finished DOF with lines. The number of its object is `16 · result + dof`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LinesId {
    /// Number of the result, or [`CURRENT_CAMPAIGN`].
    pub result: u32,
    /// Index of the DOF in the layout.
    pub dof: u8,
}

impl LinesId {
    /// The DOF with this number of its object.
    pub fn of_number(number: u32) -> Self {
        Self { result: number / DOFS, dof: (number % DOFS) as u8 }
    }

    /// The object; `None` when no object has this result and DOF.
    pub fn object(self) -> Option<ObjectId> {
        let dof = Some(u32::from(self.dof)).filter(|&dof| dof < DOFS)?;
        let number = self.result.checked_mul(DOFS)?.checked_add(dof)?;
        Some(ObjectId { kind: ObjectKind::Lines as u8, number })
    }
}

/// The head of a finished DOF with lines, of which `bytes` are the beginning; `None` when it is none.
pub fn head_of_dof(bytes: &[u8]) -> Option<LinesHead> {
    take_head(bytes).map(|(head, _)| head)
}

/// Decodes the head at the front of these bytes, and returns what follows; `None` when they begin with none.
pub fn take_head(bytes: &[u8]) -> Option<(LinesHead, &[u8])> {
    postcard::take_from_bytes(bytes).ok()
}

/// Divides the bytes of a finished DOF into its head, which is decoded, and the lines of its responses, to be decoded
/// by [`expand_response`](massline_shared::signal::expand_response). `None` when they are not a head followed by the
/// lines of one to [`RESPONSES`] responses.
pub fn split_dof<H: DeserializeOwned>(bytes: &[u8]) -> Option<(H, &[[u8; COMPACT_RESPONSE]])> {
    let (head, lines) = postcard::take_from_bytes(bytes).ok()?;
    let (responses, rest) = lines.as_chunks();
    (rest.is_empty() && (1..=RESPONSES).contains(&responses.len())).then_some((head, responses))
}

#[cfg(test)]
mod tests {
    use std::vec;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_number_stands_for_one_dof_of_one_result(number in any::<u32>()) {
            let object = LinesId::of_number(number).object();
            prop_assert_eq!(object, Some(ObjectId { kind: 4, number }));
        }
    }

    #[test]
    fn what_has_no_number_is_none() {
        let largest = LinesId { result: u32::MAX / 16, dof: 15 };
        assert_eq!(largest.object().map(|object| object.number), Some(u32::MAX));
        for none in [LinesId { result: u32::MAX / 16 + 1, dof: 0 }, LinesId { result: 1, dof: 16 }]
        {
            assert_eq!(none.object(), None, "{none:?}");
        }
        let first = LinesId { result: CURRENT_CAMPAIGN, dof: 3 };
        assert_eq!(LinesId::of_number(3), first);
    }

    #[test]
    fn a_dof_is_divided_behind_its_head() {
        for responses in 0..=RESPONSES + 1 {
            // The head is the text "ab": its length and two bytes.
            let mut bytes = vec![2, b'a', b'b'];
            for response in 0..responses {
                bytes.extend([response as u8; COMPACT_RESPONSE]);
            }
            let split = split_dof::<heapless::String<2>>(&bytes);
            assert_eq!(split.is_some(), (1..=RESPONSES).contains(&responses), "{responses}");
            if let Some((head, lines)) = split {
                assert_eq!((head.as_str(), lines.len()), ("ab", responses));
                assert!(lines.iter().enumerate().all(|(k, line)| *line == [k as u8; 513]));
            }
            bytes.pop();
            assert!(split_dof::<heapless::String<2>>(&bytes).is_none(), "{responses}, cut off");
        }
        assert!(split_dof::<heapless::String<1>>(&[2, b'a', b'b']).is_none(), "another head");
    }
}
