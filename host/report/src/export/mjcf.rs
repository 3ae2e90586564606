//! MJCF, the model of MuJoCo.
//!
//! `pos` is the centre of mass in the frame of the body; `fullinertia` is the tensor about it in the order M(1,1),
//! M(2,2), M(3,3), M(1,2), M(1,3), M(2,3) (mujoco.readthedocs.io, XML reference, body/inertial).

use massline_shared::body::elements;

use super::frame::Frame;
use super::number::shortest;
use super::subject::ExportedResult;
use super::xml::{document, name, numbers};
use massline_result::Result;

const OWN: &str = "MJCF: fullinertia is xx yy zz xy xz yz, the elements of the tensor themselves, and diaginertia \
                   xx yy zz where the products are zero, both about pos; the frame of the body is the frame above";

/// A model with one free body.
pub(super) fn write(exported: &ExportedResult) -> Result<Vec<u8>> {
    let name = name(&exported.test.title);
    let body = &exported.body;
    let (mass, position) = (shortest(body.mass), numbers(body.center_of_mass.iter().copied()));
    let inertia = if exported.placement.frame == Frame::Principal {
        ("diaginertia", numbers(body.inertia.diagonal().iter().copied()))
    } else {
        ("fullinertia", numbers(elements(&body.inertia).iter().copied()))
    };
    document(exported, OWN, |xml| {
        let model = xml.create_element("mujoco").with_attribute(("model", name.as_str()));
        model.write_inner_content(|xml| {
            xml.create_element("worldbody").write_inner_content(|xml| {
                let body = xml.create_element("body").with_attribute(("name", name.as_str()));
                body.write_inner_content(|xml| {
                    xml.create_element("freejoint").write_empty()?;
                    let attributes =
                        [("pos", position.as_str()), ("mass", &mass), (inertia.0, &inertia.1)];
                    xml.create_element("inertial").with_attributes(attributes).write_empty()?;
                    Ok(())
                })?;
                Ok(())
            })?;
            Ok(())
        })?;
        Ok(())
    })
}
