// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "byte_reader.h"
#include "types.h"

namespace spheroseg::fuzz {

/// Flips the edge at a corner of a face, if another face shares it. When `only_to_new_edge`, not
/// where the other two corners have an edge already.
void flip_edge(TriangleMesh& mesh, int face, int corner, bool only_to_new_edge = false);

/// A new vertex in the middle of a face.
void split_face(TriangleMesh& mesh, int face);

/// Deletes the faces around a vertex: a hole.
void cut_hole(TriangleMesh& mesh, int vertex);

/// The corner of a face gets a vertex of its own: a slit.
void detach_corner(TriangleMesh& mesh, int face, int corner);

/// Merges two vertices.
void replace_vertex(TriangleMesh& mesh, int from, int to);

/// One step of a random walk among meshes: one of the above, another shape beside the mesh, faces
/// removed, doubled or turned, coordinates or indices spoilt.
void change(TriangleMesh& mesh, ByteReader& bytes);

} // namespace spheroseg::fuzz
