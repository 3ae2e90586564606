//! What is exported besides an answer: title, nodes and frequency responses of a test.

use massline_shared::layout::HostLayout;

use massline_files::layout_file::{self, LayoutFile, nodes_of};
use massline_files::uff::Frf;

/// A numbered point of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Its number.
    pub id: u16,
    /// Position in the body frame, m.
    pub position: [f64; 3],
    /// Local x, y and z axis, unit vectors of the body frame; `None` when they are not known.
    pub axes: Option<[[f64; 3]; 3]>,
}

impl From<&layout_file::Node> for Node {
    fn from(node: &layout_file::Node) -> Self {
        Self { id: node.id, position: node.position, axes: Some(node.axes) }
    }
}

/// The frequency responses of a test.
#[derive(Clone, Debug, PartialEq)]
pub struct Responses {
    /// Accelerances: for each hit those of the sensors in the order of the layout, three for each, along its own axes.
    pub frfs: Vec<Frf>,
    /// The sensors and hits in the body frame.
    pub layout: HostLayout,
    /// Decay rate σ of the exponential window on force and responses, 1/s: the responses are those at `s = σ + iω`.
    pub decay_per_s: f64,
}

/// What is known of a test besides its answer.
#[derive(Clone, Debug, PartialEq)]
pub struct TestData {
    /// Name of the object: one line without control characters.
    pub title: String,
    /// Where the data come from: the name of a file, or a rig.
    pub source: String,
    /// The nodes of the layout; empty when they are not known.
    pub nodes: Vec<Node>,
    /// The frequency responses of the test; `None` when they are not known.
    pub responses: Option<Responses>,
    /// Hash of the layout of the test, when it is known.
    pub layout_hash: Option<u32>,
    /// What a person should know about how the result was read.
    pub notes: Vec<String>,
}

impl TestData {
    /// Data of which only the source is known, which is also the title.
    pub fn of_source(source: &str) -> Self {
        let source = one_line(source);
        Self {
            title: source.clone(),
            source,
            nodes: Vec::new(),
            responses: None,
            layout_hash: None,
            notes: Vec::new(),
        }
    }

    /// Takes title and nodes from the layout of the test; a layout with another hash is noted.
    pub fn with_layout(self, layout: &LayoutFile) -> Self {
        let mut with = self.titled(&layout.title);
        with.nodes = layout.nodes.iter().map(Node::from).collect();
        if let (Some(of_test), Some(given)) = (with.layout_hash, layout.hash())
            && of_test != given
        {
            with.notes.push(format!(
                "the layout differs from that of the test (hash {given:08x} instead of {of_test:08x}): make \
                 sure that its nodes are the same"
            ));
        }
        with
    }

    /// Takes title and nodes from the layout that the rig has kept, which does not have the axes of nodes.
    pub fn with_rig_layout(self, layout: HostLayout) -> Self {
        let nodes = nodes_of(&layout);
        let node = |(id, position)| Node { id, position, axes: None };
        let mut with = self.titled(layout.title.as_str());
        with.nodes = nodes.into_iter().map(node).collect();
        with
    }

    /// Takes another title, if it is not empty.
    pub fn titled(mut self, title: &str) -> Self {
        let title = one_line(title);
        if !title.is_empty() {
            self.title = title;
        }
        self
    }
}

/// The text in one line, without control characters, line separators and signs that change the direction of text.
pub fn one_line(text: &str) -> String {
    let unfit = |c: char| {
        let turns = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        c.is_control() || turns || matches!(c, '\u{2028}' | '\u{2029}' | '\u{fffe}' | '\u{ffff}')
    };
    let text: String = text.chars().map(|c| if unfit(c) { ' ' } else { c }).collect();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
