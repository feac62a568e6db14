//! Well-known text of a reference system, as a tree.

/// Deepest nesting that is read; real systems have five levels.
const DEPTH_MAX: usize = 16;

/// `KEYWORD["text", 1.0, CHILD[..]]`, in square or round brackets.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Node<'a> {
    pub keyword: &'a str,
    pub values: Vec<Value<'a>>,
}

/// What stands in a node's brackets.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value<'a> {
    /// In quotes, which are left out.
    Text(&'a str),
    /// A number, or a word such as the direction of an axis.
    Word(&'a str),
    Node(Node<'a>),
}

impl<'a> Node<'a> {
    /// Reads a text that is one node, or several with commas between them; `None` where it is not.
    pub fn read(text: &'a str) -> Option<Vec<Self>> {
        let mut rest = text.trim_start_matches('\u{feff}');
        let mut nodes = Vec::new();
        loop {
            let Value::Node(node) = value(&mut rest, 0)? else { return None };
            nodes.push(node);
            rest = rest.trim_start();
            if rest.is_empty() {
                return Some(nodes);
            }
            rest = rest.strip_prefix(',')?;
        }
    }

    /// Its first child with this keyword, whatever the case.
    pub fn child(&self, keyword: &str) -> Option<&Self> {
        self.children(keyword).next()
    }

    /// Its children that are nodes.
    pub fn nodes(&self) -> impl Iterator<Item = &Self> {
        self.values.iter().filter_map(|value| if let Value::Node(node) = value { Some(node) } else { None })
    }

    /// Its children with this keyword, whatever the case.
    pub fn children(&self, keyword: &str) -> impl Iterator<Item = &Self> {
        self.nodes().filter(move |node| node.keyword.eq_ignore_ascii_case(keyword))
    }

    /// The text or word at an index.
    pub fn text(&self, index: usize) -> Option<&'a str> {
        match self.values.get(index)? {
            Value::Text(text) | Value::Word(text) => Some(text),
            Value::Node(_) => None,
        }
    }

    /// The number at an index.
    pub fn number(&self, index: usize) -> Option<f64> {
        self.text(index)?.parse().ok()
    }
}

fn value<'a>(rest: &mut &'a str, depth: usize) -> Option<Value<'a>> {
    if depth > DEPTH_MAX {
        return None;
    }
    *rest = rest.trim_start();
    if let Some(quoted) = rest.strip_prefix('"') {
        let (text, after) = quoted.split_once('"')?;
        *rest = after;
        return Some(Value::Text(text));
    }
    let end = rest.find(['[', '(', ']', ')', ',', '"']).unwrap_or(rest.len());
    let (word, after) = rest.split_at(end);
    *rest = after;
    let (word, mut values) = (word.trim_end(), Vec::new());
    if word.is_empty() {
        return None;
    }
    let Some(inside) = rest.strip_prefix(['[', '(']) else {
        return Some(Value::Word(word));
    };
    *rest = inside;
    loop {
        values.push(value(rest, depth + 1)?);
        *rest = rest.trim_start();
        if let Some(after) = rest.strip_prefix([']', ')']) {
            *rest = after;
            return Some(Value::Node(Node { keyword: word, values }));
        }
        *rest = rest.strip_prefix(',')?;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trees_are_read() {
        let roots = Node::read("A[\"x, [y]\",\n B(1.5, east), C[\"z\"], b[\"2\"]]\n, D[3]").expect("well-formed");
        let [root, Node { keyword: "D", .. }] = &roots[..] else { panic!("{roots:?}") };
        assert_eq!((root.keyword, root.text(0)), ("A", Some("x, [y]")));
        let b: Vec<_> = root.children("B").map(|node| (node.number(0), node.text(1))).collect();
        assert_eq!(b, [(Some(1.5), Some("east")), (Some(2.0), None)]);
        assert_eq!(
            (root.child("C").and_then(|node| node.text(0)), root.text(1), root.text(9)),
            (Some("z"), None, None)
        );
    }

    #[test]
    fn what_is_no_tree_is_refused() {
        let deep = "A[".repeat(100_000);
        for text in [
            "",
            "A",
            "\"a\"",
            "A[",
            "A[]",
            "A[1",
            "A[\"1]",
            "A[1]]",
            "A[1] B",
            "A[1], B",
            "A[1],",
            "A[1,]",
            "[1]",
            "A[1 B[2]]]",
            &deep,
        ] {
            assert_eq!(Node::read(text), None, "{}", &text[..text.len().min(20)]);
        }
    }
}
