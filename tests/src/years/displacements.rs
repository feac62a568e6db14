//! How far orthophotos of several years lie apart, as another program has found it: what lies at a place of one lies elsewhere in the other.
//!
//! `tests/years/displacements.py` writes such a table. Without one the years' georeferences are taken to be true.

use plumbline_survey::error::InputError;
use plumbline_survey::io::table::{Table, text_of};
use std::collections::HashMap;
use std::path::Path;

/// Fields by the names of the files, of the ground and the reference.
#[derive(Clone, Debug, Default)]
pub struct Displacements(HashMap<(String, String), Field>);

/// What lies at a place of the ground lies so much further east and north in the reference, metres; on a grid.
#[derive(Clone, Debug, Default)]
pub struct Field {
    east_m: Vec<f64>,
    north_m: Vec<f64>,
    /// Row by row from the south.
    apart_m: Vec<[f64; 2]>,
}

const COLUMNS: [&str; 4] = ["east_m", "north_m", "d_east_m", "d_north_m"];

impl Displacements {
    /// Reads the table: `ground,reference,east_m,north_m,d_east_m,d_north_m`, the nodes of each pair a full grid.
    ///
    /// # Errors
    /// The file or a number of it cannot be read, or the nodes of a pair are no grid.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let (text, name) = text_of(path)?;
        Self::parse(&text, name)
    }

    fn parse(text: &str, name: String) -> Result<Self, InputError> {
        let table = Table::parse(text, name)?;
        let names = table.columns(["ground", "reference"])?;
        let columns = table.columns(COLUMNS)?;
        let mut nodes: HashMap<(String, String), Vec<[f64; 4]>> = HashMap::new();
        for row in 0..table.rows.len() {
            let [ground, reference] = names.map(|column| table.rows[row].1[column].to_owned());
            nodes.entry((ground, reference)).or_default().push(table.numbers_of(row, columns)?);
        }
        let field = |(pair, nodes): ((String, String), Vec<[f64; 4]>)| match Field::new(nodes) {
            Some(field) => Ok((pair, field)),
            None => Err(InputError::new(format!("{}: the nodes of {} in {} are no grid", table.name, pair.0, pair.1))),
        };
        nodes.into_iter().map(field).collect::<Result<_, _>>().map(Displacements)
    }

    /// The field of a pair of files.
    ///
    /// # Errors
    /// The table has none.
    pub fn between(&self, ground: &str, reference: &str) -> Result<&Field, InputError> {
        let missing = || InputError::new(format!("the table of displacements has none of {ground} in {reference}"));
        self.0.get(&(ground.to_owned(), reference.to_owned())).ok_or_else(missing)
    }
}

impl Field {
    /// Of nodes (east, north, further east, further north); `None` where they are no full grid.
    fn new(mut nodes: Vec<[f64; 4]>) -> Option<Self> {
        let axis = |k: usize| {
            let mut values: Vec<f64> = nodes.iter().map(|node| node[k]).collect();
            values.sort_by(f64::total_cmp);
            values.dedup();
            values
        };
        let (east_m, north_m) = (axis(0), axis(1));
        nodes.sort_by(|a, b| a[1].total_cmp(&b[1]).then(a[0].total_cmp(&b[0])));
        let places = north_m.iter().flat_map(|&north| east_m.iter().map(move |&east| [east, north]));
        let is_full = nodes.len() == east_m.len() * north_m.len()
            && nodes.iter().zip(places).all(|(node, place)| node[..2] == place);
        let apart_m = nodes.iter().map(|node| [node[2], node[3]]).collect();
        is_full.then_some(Field { east_m, north_m, apart_m })
    }

    /// How much further (east, north) what lies at a place is, metres: bilinear between nodes, beyond the outermost as at them.
    #[must_use]
    pub fn at(&self, east_m: f64, north_m: f64) -> [f64; 2] {
        let ((left, u), (low, v)) = (between(&self.east_m, east_m), between(&self.north_m, north_m));
        let cols = self.east_m.len();
        let node = |dc: usize, dr: usize, axis: usize| {
            let at = (low + dr).min(self.north_m.len() - 1) * cols + (left + dc).min(cols - 1);
            self.apart_m.get(at).map_or(0.0, |apart| apart[axis])
        };
        [0, 1].map(|axis| {
            let [below, above] = [0, 1].map(|dr| (1.0 - u) * node(0, dr, axis) + u * node(1, dr, axis));
            (1.0 - v) * below + v * above
        })
    }
}

/// The last of sorted `values` that is not above one, and how far on to the next it is, 0 to 1.
fn between(values: &[f64], value: f64) -> (usize, f64) {
    let at = values.partition_point(|&other| other <= value).saturating_sub(1).min(values.len().saturating_sub(2));
    match (values.get(at), values.get(at + 1)) {
        (Some(from), Some(to)) => (at, ((value - from) / (to - from)).clamp(0.0, 1.0)),
        _ => (0, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::Displacements;

    const HEAD: &str = "ground,reference,east_m,north_m,d_east_m,d_north_m\n";
    const GRID: &str = "a,b,0,0,1,-2\na,b,10,0,3,-2\na,b,0,20,1,2\na,b,10,20,3,2\n";

    #[test]
    fn a_field_is_bilinear_and_goes_on_beyond_its_nodes() {
        let table = Displacements::parse(&format!("{HEAD}{GRID}"), "d.csv".into()).expect("a table");
        let field = table.between("a", "b").expect("the pair");
        assert_eq!(
            [field.at(0.0, 0.0), field.at(10.0, 20.0), field.at(5.0, 5.0)],
            [[1.0, -2.0], [3.0, 2.0], [2.0, -1.0]]
        );
        assert_eq!([field.at(-9.0, -9.0), field.at(99.0, 10.0)], [[1.0, -2.0], [3.0, 0.0]]);
        assert!(table.between("b", "a").expect_err("the other way").to_string().contains("b in a"));
    }

    #[test]
    fn nodes_that_are_no_grid_are_refused() {
        for wrong in ["a,b,10,20,3,2\n", "a,b,5,5,0,0\n"] {
            let said = Displacements::parse(&format!("{HEAD}{GRID}{wrong}"), "d.csv".into()).expect_err("no grid");
            assert!(said.to_string().contains("d.csv: the nodes of a in b"), "{said}");
        }
        let one = Displacements::parse(&format!("{HEAD}a,b,4,4,1,2\n"), "d.csv".into()).expect("one node");
        assert_eq!(one.between("a", "b").expect("the pair").at(9.0, 9.0), [1.0, 2.0]);
        assert!(Displacements::parse(&format!("{HEAD}a,b,4,x,1,2\n"), "d.csv".into()).is_err());
    }
}
