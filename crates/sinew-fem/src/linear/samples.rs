//! Matrices that tests factorise.

/// A sparse symmetric matrix, its lower half by columns.
pub(super) struct Sample {
    pub starts: Vec<usize>,
    pub rows: Vec<usize>,
    pub values: Vec<f64>,
}

impl Sample {
    /// The matrix with an entry for each pair of neighbours in a graph and with the given diagonal.
    pub fn of_graph(graph: &[Vec<usize>], diagonal: impl Fn(usize) -> f64) -> Self {
        let (mut starts, mut rows, mut values) = (vec![0], vec![], vec![]);
        for (column, neighbours) in graph.iter().enumerate() {
            rows.push(column);
            values.push(diagonal(column));
            let below = neighbours.iter().filter(|&&row| row > column);
            for &row in below {
                rows.push(row);
                values.push(-1.0 + ((row * 7 + column * 13) % 10) as f64 / 20.0);
            }
            starts.push(rows.len());
        }
        Self { starts, rows, values }
    }

    pub fn size(&self) -> usize {
        self.starts.len() - 1
    }

    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for column in 0..self.size() {
            for entry in self.starts[column]..self.starts[column + 1] {
                let (row, value) = (self.rows[entry], self.values[entry]);
                y[row] += value * x[column];
                if row != column {
                    y[column] += value * x[row];
                }
            }
        }
        y
    }
}

/// A grid in which each vertex is joined to those next to it, diagonally too.
pub(super) fn grid(size: [usize; 3]) -> Vec<Vec<usize>> {
    let index = |at: [usize; 3]| at[0] + size[0] * (at[1] + size[1] * at[2]);
    let near = |x: usize, bound: usize| x.saturating_sub(1)..(x + 2).min(bound);
    let mut graph = Vec::new();
    for z in 0..size[2] {
        for y in 0..size[1] {
            for x in 0..size[0] {
                let mut neighbours = Vec::new();
                for c in near(z, size[2]) {
                    for b in near(y, size[1]) {
                        neighbours.extend(near(x, size[0]).map(|a| index([a, b, c])));
                    }
                }
                neighbours.retain(|&n| n != index([x, y, z]));
                graph.push(neighbours);
            }
        }
    }
    graph
}

/// The graph whose vertex `i` is vertex `order[i]` of another.
pub(super) fn reordered(graph: &[Vec<usize>], order: &[usize]) -> Vec<Vec<usize>> {
    let mut place = vec![usize::MAX; graph.len()];
    order.iter().enumerate().for_each(|(at, &vertex)| place[vertex] = at);
    let moved = |&vertex: &usize| {
        let mut neighbours: Vec<_> = graph[vertex].iter().map(|&n| place[n]).collect();
        neighbours.sort_unstable();
        neighbours
    };
    order.iter().map(moved).collect()
}

/// Starts and neighbours of a graph, compressed.
pub(super) fn compressed(graph: &[Vec<usize>]) -> (Vec<usize>, Vec<usize>) {
    let mut starts = vec![0];
    for neighbours in graph {
        starts.push(starts[starts.len() - 1] + neighbours.len());
    }
    (starts, graph.concat())
}
