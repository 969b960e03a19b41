// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "errors.h"
#include "types.h"

#include <fstream>
#include <string>

namespace spheroseg {

/// Reads the file that scripts/reproduce.py writes: V and F as int32, then 3 V doubles and 3 F
/// int32, in the byte order of the machine.
inline TriangleMesh read_raw_mesh(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::int32_t counts[2] = {0, 0};
    file.read(reinterpret_cast<char*>(counts), sizeof counts);
    TriangleMesh mesh;
    if (file) {
        mesh.positions.resize(counts[0]);
        mesh.faces.resize(counts[1]);
        file.read(reinterpret_cast<char*>(mesh.positions.data()), sizeof(Vec3) * counts[0]);
        file.read(reinterpret_cast<char*>(mesh.faces.data()), sizeof(Triangle) * counts[1]);
    }
    if (!file) {
        throw InvalidInput("Expected a raw mesh in " + path +
                           ", found a missing or short file. Make it with scripts/reproduce.py.");
    }
    return mesh;
}

} // namespace spheroseg
