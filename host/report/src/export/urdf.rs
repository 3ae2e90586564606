//! URDF, the robot description of ROS.
//!
//! `<inertial>` has its `<origin>` at the centre of mass; `<inertia>` holds the elements of the tensor about it, along
//! the axes of that origin (wiki.ros.org/urdf/XML/link, docs.ros.org "Adding physical and collision properties").

use massline_shared::body::elements;

use super::number::shortest;
use super::subject::ExportedResult;
use super::xml::{document, name, numbers};
use massline_result::Result;

const OWN: &str = "URDF: ixy, ixz, iyz are the elements of the tensor themselves, about the origin \
                   of <inertial>; the frame of the link is the frame above";

/// A robot with one link.
pub(super) fn write(exported: &ExportedResult) -> Result<Vec<u8>> {
    let name = name(&exported.test.title);
    let [xx, yy, zz, xy, xz, yz] = <[f64; 6]>::from(elements(&exported.body.inertia)).map(shortest);
    let center = numbers(exported.body.center_of_mass.iter().copied());
    let mass = shortest(exported.body.mass);
    document(exported, OWN, |xml| {
        let robot = xml.create_element("robot").with_attribute(("name", name.as_str()));
        robot.write_inner_content(|xml| {
            let link = xml.create_element("link").with_attribute(("name", name.as_str()));
            link.write_inner_content(|xml| {
                xml.create_element("inertial").write_inner_content(|xml| {
                    let origin = [("xyz", center.as_str()), ("rpy", "0 0 0")];
                    xml.create_element("origin").with_attributes(origin).write_empty()?;
                    let mass = ("value", mass.as_str());
                    xml.create_element("mass").with_attribute(mass).write_empty()?;
                    let attributes = [
                        ("ixx", xx.as_str()),
                        ("ixy", &xy),
                        ("ixz", &xz),
                        ("iyy", &yy),
                        ("iyz", &yz),
                        ("izz", &zz),
                    ];
                    xml.create_element("inertia").with_attributes(attributes).write_empty()?;
                    Ok(())
                })?;
                Ok(())
            })?;
            Ok(())
        })?;
        Ok(())
    })
}
