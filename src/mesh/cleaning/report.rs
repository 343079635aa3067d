//! What cleaning changed.

use serde::Serialize;

/// What cleaning changed, in numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RepairReport {
    /// Vertices at the place of an earlier one, made one with it.
    pub welded_vertices: usize,
    /// Polygons of four and more corners cut into triangles (no repair: the surface is the same).
    pub cut_polygons: usize,
    /// Triangles without area, dropped.
    pub empty_triangles: usize,
    /// Triangles with the same corners as an earlier one, dropped.
    pub repeated_triangles: usize,
    /// Components smaller than asked, dropped.
    pub specks: usize,
    /// Triangles flipped to face as their neighbours do.
    pub turned_triangles: usize,
    /// Edges cut because three and more triangles met there.
    pub cut_edges: usize,
    /// Edges cut because the surface has but one side (a Möbius strip).
    pub one_sided_edges: usize,
    /// Vertices added where surfaces met in a point or cut edge.
    pub split_vertices: usize,
    /// Vertices in no triangle, kept in their place.
    pub unused_vertices: usize,
    /// The first thing that was wrong, by its place in the file.
    pub first: Option<String>,
    /// The components that were flipped, whole or in part.
    pub turned_components: Vec<FlippedComponent>,
    /// Faces that the reader left out.
    pub notes: Vec<String>,
    /// What the file holds beside the surface and could not be used: no repair.
    pub unused: Vec<String>,
}

/// A component of which triangles were flipped to face one way.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FlippedComponent {
    /// Its triangles.
    pub triangles: usize,
    /// Those that were flipped.
    pub turned: usize,
    /// The middle of its box, in the file's coordinates.
    pub centre: [f64; 3],
}

impl FlippedComponent {
    fn line(&self) -> String {
        let [x, y, z] = self.centre;
        format!(
            "component round ({x:.6}, {y:.6}, {z:.6}): {} of {} triangles flipped",
            self.turned, self.triangles
        )
    }
}

/// Flipped components that are named one by one.
const NAMED: usize = 8;

impl RepairReport {
    /// Whether the file was sound as it was: nothing left out, cut, turned or split. Vertices a
    /// format must repeat, polygons and unused vertices are no fault.
    pub fn is_sound(&self) -> bool {
        self.empty_triangles == 0
            && self.repeated_triangles == 0
            && self.specks == 0
            && self.turned_triangles == 0
            && self.cut_edges == 0
            && self.one_sided_edges == 0
            && self.split_vertices == 0
            && self.notes.is_empty()
    }

    /// One line for every kind of change.
    pub fn lines(&self) -> Vec<String> {
        // Count each kind of change.
        let counts = [
            (
                self.welded_vertices,
                "vertices merged with another at the same position",
            ),
            (self.cut_polygons, "polygons triangulated"),
            (self.empty_triangles, "triangles without area removed"),
            (self.repeated_triangles, "repeated triangles dropped"),
            (self.specks, "specks dropped"),
            (
                self.turned_triangles,
                "triangles flipped to face like their neighbours",
            ),
            (self.cut_edges, "edges of three and more triangles split"),
            (
                self.one_sided_edges,
                "edges cut to give the surface two sides",
            ),
            (
                self.split_vertices,
                "vertices added where surfaces met in a point or cut edge",
            ),
            (self.unused_vertices, "vertices in no triangle kept"),
        ];
        let told = counts.iter().filter(|(count, _)| *count > 0);
        let mut lines: Vec<String> = told
            .map(|(count, what)| format!("{count} {what}"))
            .collect();
        // Name the components that were flipped, as far as there is room.
        let named = self.turned_components.iter().take(NAMED);
        lines.extend(named.map(FlippedComponent::line));
        if let Some(more @ 1..) = self.turned_components.len().checked_sub(NAMED) {
            lines.push(format!("{more} more components flipped"));
        }
        lines.extend(self.notes.iter().cloned());
        lines
    }

    pub(super) fn say_first(&mut self, what: impl FnOnce() -> String) {
        if self.first.is_none() {
            self.first = Some(what());
        }
    }
}
