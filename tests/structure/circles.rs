//! Circles among the modules of one folder, and uses against the declared order.

use crate::modules::{Crate, Name, Use};
use std::collections::{BTreeMap, BTreeSet};

/// Which module of a folder uses which other one of it, itself or by what it contains, and where.
#[derive(Debug, Default)]
pub struct Siblings {
    uses: BTreeMap<String, BTreeMap<String, Vec<String>>>,
}

/// The uses among the modules within each module.
pub fn siblings(modules: &Crate) -> BTreeMap<Name, Siblings> {
    let mut folders: BTreeMap<Name, Siblings> = BTreeMap::new();
    for Use { from, to, place } in modules.uses() {
        let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
        // One contains the other: a module and what it is made of are one.
        let (Some(user), Some(used)) = (from.get(common), to.get(common)) else { continue };
        let uses = &mut folders.entry(from[..common].to_vec()).or_default().uses;
        uses.entry(user.clone()).or_default().entry(used.clone()).or_default().push(place);
    }
    folders
}

impl Siblings {
    /// The modules that lie on a circle: those that use themselves in the end.
    pub fn on_circles(&self) -> Vec<String> {
        self.uses.keys().filter(|&name| self.reached(name).contains(name)).cloned().collect()
    }

    /// The uses between two modules of one circle, as sentences.
    pub fn on_circle_with(&self, name: &str) -> Vec<String> {
        let used = self.uses.get(name).into_iter().flatten();
        let back = used.filter(|(to, _)| self.reached(to).contains(name));
        back.map(|(to, places)| sentence(name, to, places)).collect()
    }

    /// What a module uses, and what that uses, and so on.
    fn reached(&self, name: &str) -> BTreeSet<String> {
        let (mut reached, mut open) = (BTreeSet::new(), vec![name.to_owned()]);
        while let Some(next) = open.pop() {
            let used = self.uses.get(&next).into_iter().flat_map(BTreeMap::keys);
            open.extend(used.filter(|used| reached.insert((*used).clone())).cloned());
        }
        reached
    }

    /// The uses of a module by one that is declared before it, as sentences.
    pub fn against(&self, order: &[String]) -> Vec<String> {
        let at = |name: &String| order.iter().position(|other| other == name);
        let all = self.uses.iter().flat_map(|(from, used)| used.iter().map(move |(to, places)| (from, to, places)));
        let wrong = all.filter(|(from, to, _)| at(to) > at(from));
        wrong.map(|(from, to, places)| sentence(from, to, places)).collect()
    }
}

/// Who uses what, and the first places where.
fn sentence(from: &str, to: &str, places: &[String]) -> String {
    format!("{from} uses {to}, {}", places[..places.len().min(PLACES)].join(", "))
}

/// Places that are told of a use.
const PLACES: usize = 2;
