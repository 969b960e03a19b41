// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "collapse_mesh.h"

namespace spheroseg {

/// Closes the holes of a mesh with caps, see CollapseMesh: each closed border loop gets one.
///
/// At a vertex where several fans of faces meet, the border is taken to lead from the end of each
/// fan to the begin of the next one, so that the fans and the caps between them become one closed
/// fan. At a vertex with a single fan whose faces are not oriented alike, as at the seam of a
/// Moebius band, it leads from one end of the fan to the other. Borders stay open at a vertex with
/// several fans of which one is not oriented alike, and at an edge with more than two faces.
void close_holes(CollapseMesh& mesh);

} // namespace spheroseg
