//! SDFormat, the model description of Gazebo and Drake.
//!
//! `<pose>` of `<inertial>` puts its frame at the centre of mass; `<inertia>` holds the elements of the tensor about
//! it, along the axes of that frame (sdformat.org, specification of `<inertial>`).

use massline_shared::body::elements;
use quick_xml::events::BytesText;

use super::number::shortest;
use super::subject::ExportedResult;
use super::xml::{document, name, numbers};
use massline_result::Result;

/// The version that Gazebo Classic 11, Gazebo Sim and Drake all read.
const VERSION: &str = "1.7";

const OWN: &str = "SDFormat: ixy, ixz, iyz are the elements of the tensor themselves, about the pose \
                   of <inertial>; the frame of the link is the frame above";

/// A model with one link.
pub(super) fn write(exported: &ExportedResult) -> Result<Vec<u8>> {
    let name = name(&exported.test.title);
    let body = &exported.body;
    let [xx, yy, zz, xy, xz, yz] = <[f64; 6]>::from(elements(&body.inertia)).map(shortest);
    let pose = format!("{} 0 0 0", numbers(body.center_of_mass.iter().copied()));
    let mass = shortest(body.mass);
    document(exported, OWN, |xml| {
        let sdf = xml.create_element("sdf").with_attribute(("version", VERSION));
        sdf.write_inner_content(|xml| {
            let model = xml.create_element("model").with_attribute(("name", name.as_str()));
            model.write_inner_content(|xml| {
                let link = xml.create_element("link").with_attribute(("name", name.as_str()));
                link.write_inner_content(|xml| {
                    xml.create_element("inertial").write_inner_content(|xml| {
                        let text = |text| BytesText::new(text);
                        xml.create_element("pose").write_text_content(text(&pose))?;
                        xml.create_element("mass").write_text_content(text(&mass))?;
                        xml.create_element("inertia").write_inner_content(|xml| {
                            for (name, value) in [
                                ("ixx", &xx),
                                ("ixy", &xy),
                                ("ixz", &xz),
                                ("iyy", &yy),
                                ("iyz", &yz),
                                ("izz", &zz),
                            ] {
                                xml.create_element(name).write_text_content(text(value))?;
                            }
                            Ok(())
                        })?;
                        Ok(())
                    })?;
                    Ok(())
                })?;
                Ok(())
            })?;
            Ok(())
        })?;
        Ok(())
    })
}
