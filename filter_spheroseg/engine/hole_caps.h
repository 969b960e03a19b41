// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "collapse_mesh.h"

namespace spheroseg {

/// Closes the holes of a mesh with caps, see CollapseMesh. Where several fans meet at a vertex,
/// each border goes on at the next fan, so that they and the caps between them become one closed
/// fan. A border goes on where the one fan of a vertex has faces that are oriented differently.
/// Borders where several fans meet at such a vertex, or where an edge has more than two faces,
/// stay.
void close_holes(CollapseMesh& mesh);

} // namespace spheroseg
