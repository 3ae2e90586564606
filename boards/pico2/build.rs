//! How the image is linked.

#[path = "../cortex-m/build/image.rs"]
mod image;

fn main() {
    image::link(&["link.x"]);
}
