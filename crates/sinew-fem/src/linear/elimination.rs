//! What is known about a Cholesky factor before the numbers.

use super::trapezoid::Trapezoid;
use std::ops::Range;

/// A front merges with its last child while the zeros that are stored for it are below a part of the front's
/// entries: (most pivots, part). Half or twice as many zeros cost 2 to 10 % of the time for 1000 to 5000 unknowns.
const RELAXATION: [(usize, f64); 4] = [(8, 1.0), (32, 0.6), (96, 0.12), (usize::MAX, 0.05)];

/// Subtrees with more operations than this may be worked on by a thread of their own ...
const PARALLEL_SUBTREE: f64 = 3e6;
/// ... where what waits in the workspace meanwhile stays below this part of the factor. Larger fronts are
/// parallel in themselves.
const PARALLEL_WORKSPACE: f64 = 0.05;
/// Fronts with more pivots than this merge with none of that kind: their blocks are large enough.
const WIDE: usize = 256;

/// The elimination of a sparse symmetric matrix by fronts (I. S. Duff, J. K. Reid, ACM Trans. Math. Softw. 9, 1983):
/// pivots whose columns have one pattern, which are eliminated as a dense matrix.
#[derive(Debug)]
pub(super) struct Elimination {
    pub size: usize,
    /// Where the columns of the matrix start in its entries.
    pub starts: Vec<usize>,
    /// Children before their parents.
    pub fronts: Vec<Front>,
    /// Fronts without a parent.
    pub roots: Vec<u32>,
    /// Children of all fronts.
    pub children: Vec<u32>,
    /// Rows below the pivots of all fronts, ascending per front.
    pub rows: Vec<u32>,
    /// The place of each of these rows in the parent's front.
    pub relative: Vec<u32>,
    /// Place of each entry of the matrix in the entries of its front.
    pub scatter: Vec<u32>,
    /// Number of entries of the factor.
    pub entries: usize,
    /// Entries of the updates that wait for their parents, on both sides of the workspace.
    pub workspace: [usize; 2],
}

/// A front: pivot columns, and what they change below.
#[derive(Clone, Debug)]
pub(super) struct Front {
    pub pivots: Range<usize>,
    /// Where its rows below the pivots are in [`Elimination::rows`].
    pub rows: Range<usize>,
    /// Where its entries start in the factor.
    pub start: usize,
    pub children: Range<usize>,
    /// First front of its subtree, which ends with itself.
    pub subtree: usize,
    /// Where its update is, in the side of the workspace that its depth tells.
    pub update: usize,
    /// Starts of what its subtree uses of both sides, its own first.
    base: [usize; 2],
    /// Size of what its subtree uses of both sides, its own first.
    need: [usize; 2],
    pub odd: bool,
    /// Whether its children's subtrees are worked on in parallel.
    pub parallel: bool,
    /// Whether that holds for any front of its subtree.
    pub split: bool,
    /// Operations of the front.
    pub flops: f64,
    parent: Option<usize>,
}

impl Front {
    /// The shape of the factor's columns.
    pub fn columns(&self) -> Trapezoid {
        Trapezoid { rows: self.pivots.len() + self.rows.len(), columns: self.pivots.len() }
    }

    /// The shape of the update: what the pivots change in the rows below.
    pub fn update_shape(&self) -> Trapezoid {
        Trapezoid { rows: self.rows.len(), columns: self.rows.len() }
    }

    /// Parts of the workspace that its subtree uses, even and odd depths.
    pub fn workspace(&self) -> [Range<usize>; 2] {
        let [own, other] = [0, 1].map(|i| self.base[i]..self.base[i] + self.need[i]);
        if self.odd { [other, own] } else { [own, other] }
    }
}

impl Elimination {
    /// Analyses the lower half of a matrix, compressed by columns with ascending rows, in its given order.
    pub fn new(starts: &[usize], rows: &[usize]) -> Self {
        let mut supernodes = Supernodes::find(starts, rows);
        supernodes.merge();
        let tree = Tree::new(&supernodes);
        tree.elimination(&supernodes, starts, rows)
    }
}

/// Pivots with their pattern, in the order of the pivots.
struct Supernodes {
    /// Pivots; empty where a supernode was merged into its parent.
    pivots: Vec<Range<usize>>,
    /// Rows below the pivots.
    below: Vec<Range<usize>>,
    rows: Vec<u32>,
    /// The supernode of each pivot.
    of_pivot: Vec<u32>,
}

impl Supernodes {
    /// Columns in a row that have the same pattern below, each the only child of the next.
    fn find(starts: &[usize], rows: &[usize]) -> Self {
        let size = starts.len() - 1;
        let mut found =
            Self { pivots: vec![], below: vec![], rows: vec![], of_pivot: vec![0; size] };
        // First child of each column and next sibling of each supernode.
        const NONE: u32 = u32::MAX;
        let (mut child, mut sibling) = (vec![NONE; size], Vec::new());
        let mut seen = vec![NONE; size];
        for column in 0..size {
            let own = rows[starts[column]..starts[column + 1]].iter().filter(|&&r| r > column);
            let first = child[column];
            let only = first != NONE && sibling[first as usize] == NONE;
            if only && found.continues(first as usize, column, own.clone()) {
                let (pivots, below) =
                    (&mut found.pivots[first as usize], &mut found.below[first as usize]);
                pivots.end += 1;
                below.start += 1;
                found.of_pivot[column] = first;
            } else {
                let new = found.pivots.len() as u32;
                let start = found.rows.len();
                for &row in own {
                    seen[row] = new;
                    found.rows.push(row as u32);
                }
                let mut next = first;
                while next != NONE {
                    for at in found.below[next as usize].clone() {
                        let row = found.rows[at];
                        if row as usize != column && seen[row as usize] != new {
                            seen[row as usize] = new;
                            found.rows.push(row);
                        }
                    }
                    next = sibling[next as usize];
                }
                found.rows[start..].sort_unstable();
                found.pivots.push(column..column + 1);
                found.below.push(start..found.rows.len());
                found.of_pivot[column] = new;
                sibling.push(NONE);
            }
            let supernode = found.of_pivot[column] as usize;
            if let Some(&parent) = found.rows[found.below[supernode].clone()].first() {
                sibling[supernode] = child[parent as usize];
                child[parent as usize] = supernode as u32;
            }
        }
        found
    }

    /// Whether a column has the pattern of a supernode that ends before it.
    fn continues<'r>(
        &self,
        supernode: usize,
        column: usize,
        mut own: impl Iterator<Item = &'r usize>,
    ) -> bool {
        let below = &self.rows[self.below[supernode].clone()];
        self.pivots[supernode].end == column
            && own.all(|&row| below.binary_search(&(row as u32)).is_ok())
    }

    fn parent(&self, supernode: usize) -> Option<usize> {
        let first = self.rows[self.below[supernode].clone()].first()?;
        Some(self.of_pivot[*first as usize] as usize)
    }

    /// Merges supernodes with the child before them where that stores few zeros: larger dense blocks are
    /// faster than exact ones.
    fn merge(&mut self) {
        let mut zeros = vec![0usize; self.pivots.len()];
        // The supernode that ends where another starts, while nothing was merged between them.
        for parent in 0..self.pivots.len() {
            while let Some(before) = self.pivots[parent].start.checked_sub(1) {
                let child = self.of_pivot[before] as usize;
                if self.parent(child) != Some(parent) {
                    break;
                }
                let (own, added) = (self.pivots[parent].len(), self.pivots[child].len());
                if own > WIDE && added > WIDE {
                    break;
                }
                let missing = own + self.below[parent].len() - self.below[child].len();
                let stored = zeros[parent] + zeros[child] + missing * added;
                let pivots = own + added;
                let entries = pivots * (pivots + 1) / 2 + pivots * self.below[parent].len();
                let few = |&(most, part): &(usize, f64)| {
                    pivots <= most && stored as f64 <= part * entries as f64
                };
                if missing > 0 && !RELAXATION.iter().any(few) {
                    break;
                }
                zeros[parent] = stored;
                let merged = self.pivots[child].clone();
                self.pivots[parent].start = merged.start;
                self.pivots[child] = 0..0;
                self.of_pivot[merged].fill(parent as u32);
            }
        }
    }
}

/// The tree of supernodes that are left, children in the order that needs least memory.
struct Tree {
    children: Vec<Vec<u32>>,
    roots: Vec<u32>,
    /// Operations in the subtree of each supernode.
    flops: Vec<f64>,
    need: Vec<[usize; 2]>,
    parallel: Vec<bool>,
}

/// Operations to eliminate `pivots` columns with `below` rows below them.
fn operations(pivots: usize, below: usize) -> f64 {
    (0..pivots).map(|i| (below + pivots - i) as f64).map(|length| length * length).sum()
}

impl Tree {
    fn new(supernodes: &Supernodes) -> Self {
        let count = supernodes.pivots.len();
        let mut tree = Self {
            children: vec![Vec::new(); count],
            roots: Vec::new(),
            flops: vec![0.0; count],
            need: vec![[0; 2]; count],
            parallel: vec![false; count],
        };
        let present = || (0..count).filter(|&s| !supernodes.pivots[s].is_empty());
        let update = |s: usize| {
            let rows = supernodes.below[s].len();
            Trapezoid { rows, columns: rows }.len()
        };
        for s in present() {
            tree.flops[s] += operations(supernodes.pivots[s].len(), supernodes.below[s].len());
            match supernodes.parent(s) {
                Some(parent) => {
                    tree.children[parent].push(s as u32);
                    tree.flops[parent] += tree.flops[s];
                }
                None => tree.roots.push(s as u32),
            }
        }
        let columns = |s: usize| {
            let (pivots, below) = (supernodes.pivots[s].len(), supernodes.below[s].len());
            Trapezoid { rows: pivots + below, columns: pivots }.len()
        };
        let most_waiting = PARALLEL_WORKSPACE * present().map(columns).sum::<usize>() as f64;
        for s in present() {
            let mut children = std::mem::take(&mut tree.children[s]);
            let needs = |c: u32| tree.need[c as usize];
            children.sort_by_key(|&c| {
                std::cmp::Reverse(needs(c)[0].saturating_sub(update(c as usize)))
            });
            let (mut own, mut other, mut waiting) = (0, 0, 0);
            let mut all = [0; 2];
            for &c in &children {
                let [child_own, child_other] = needs(c);
                all = [all[0] + child_other, all[1] + child_own];
                own = own.max(child_other);
                other = other.max(waiting + child_own);
                waiting += update(c as usize);
            }
            let worthy = |c: &&u32| tree.flops[**c as usize] > PARALLEL_SUBTREE;
            let fits = (all[0] + all[1]) as f64 <= most_waiting;
            tree.parallel[s] = fits && children.iter().filter(worthy).count() > 1;
            if tree.parallel[s] {
                [own, other] = all;
            }
            tree.need[s] = [own.max(update(s)), other];
            tree.children[s] = children;
        }
        tree
    }

    fn elimination(self, supernodes: &Supernodes, starts: &[usize], rows: &[usize]) -> Elimination {
        let size = starts.len() - 1;
        let mut result = Elimination {
            size,
            starts: starts.to_vec(),
            fronts: Vec::new(),
            roots: Vec::new(),
            children: Vec::new(),
            rows: Vec::new(),
            relative: Vec::new(),
            scatter: vec![0; rows.len()],
            entries: 0,
            workspace: [0; 2],
        };
        let number = self.number(supernodes, &mut result);
        result.roots = self.roots.iter().map(|&s| number[s as usize]).collect();
        place_updates(&mut result);
        result.relative = vec![0; result.rows.len()];
        for front in 0..result.fronts.len() {
            relate(&mut result, front);
            scatter(&mut result, front, starts, rows);
        }
        result
    }

    /// Appends the fronts, children before parents; returns the front of each supernode.
    fn number(&self, supernodes: &Supernodes, result: &mut Elimination) -> Vec<u32> {
        // Supernodes to visit, with the number of fronts when their subtree was entered.
        let mut stack: Vec<(u32, Option<usize>)> =
            self.roots.iter().rev().map(|&s| (s, None)).collect();
        let mut number = vec![0u32; self.children.len()];
        while let Some((supernode, entered)) = stack.pop() {
            let s = supernode as usize;
            let Some(subtree) = entered else {
                stack.push((supernode, Some(result.fronts.len())));
                stack.extend(self.children[s].iter().rev().map(|&c| (c, None)));
                continue;
            };
            let index = result.fronts.len();
            number[s] = index as u32;
            let first_child = result.children.len();
            for &c in &self.children[s] {
                let child = number[c as usize];
                result.fronts[child as usize].parent = Some(index);
                result.children.push(child);
            }
            let first_row = result.rows.len();
            result.rows.extend(&supernodes.rows[supernodes.below[s].clone()]);
            let front = Front {
                pivots: supernodes.pivots[s].clone(),
                rows: first_row..result.rows.len(),
                start: result.entries,
                children: first_child..result.children.len(),
                subtree,
                update: 0,
                base: [0; 2],
                need: self.need[s],
                odd: false,
                parallel: self.parallel[s],
                split: self.parallel[s]
                    || self.children[s]
                        .iter()
                        .any(|&c| result.fronts[number[c as usize] as usize].split),
                flops: operations(supernodes.pivots[s].len(), supernodes.below[s].len()),
                parent: None,
            };
            result.entries += front.columns().len();
            result.fronts.push(front);
        }
        number
    }
}

/// Gives each update its place. Updates of fronts at even depths wait on one side of the workspace, those at odd
/// depths on the other, so a front's update never overlaps its children's.
fn place_updates(result: &mut Elimination) {
    for index in (0..result.fronts.len()).rev() {
        let front = result.fronts[index].clone();
        let [own, other] = front.base;
        result.fronts[index].update = own;
        for (side, end) in [own + front.need[0], other + front.need[1]].into_iter().enumerate() {
            let side = if front.odd { 1 - side } else { side };
            result.workspace[side] = result.workspace[side].max(end);
        }
        let (mut next_own, mut next_other) = (other, own);
        for child in front.children {
            let child = &mut result.fronts[result.children[child] as usize];
            child.base = [next_own, next_other];
            child.odd = !front.odd;
            if front.parallel {
                next_own += child.need[0];
                next_other += child.need[1];
            } else {
                next_own += child.update_shape().len();
            }
        }
    }
}

/// Finds the rows of a front in its parent.
fn relate(result: &mut Elimination, front: usize) {
    let Some(parent) = result.fronts[front].parent else { return };
    let (front, parent) = (&result.fronts[front], &result.fronts[parent]);
    let mut at = parent.rows.start;
    for own in front.rows.clone() {
        let row = result.rows[own];
        result.relative[own] = if (row as usize) < parent.pivots.end {
            row - parent.pivots.start as u32
        } else {
            while result.rows[at] < row {
                at += 1;
            }
            (parent.pivots.len() + at - parent.rows.start) as u32
        };
    }
}

/// Finds the entries of the matrix in a front.
fn scatter(result: &mut Elimination, front: usize, starts: &[usize], rows: &[usize]) {
    let front = &result.fronts[front];
    let shape = front.columns();
    for (inside, column) in front.pivots.clone().enumerate() {
        let diagonal = shape.column(inside);
        let mut at = front.rows.start;
        for entry in starts[column]..starts[column + 1] {
            let row = rows[entry];
            let local = if row < front.pivots.end {
                row - front.pivots.start
            } else {
                while (result.rows[at] as usize) < row {
                    at += 1;
                }
                front.pivots.len() + at - front.rows.start
            };
            result.scatter[entry] = (diagonal + local - inside) as u32;
        }
    }
}
