// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <charconv>
#include <new>
#include <stdexcept>
#include <string>

namespace spheroseg {

// Every message says what was expected, what was found (with index and value), and what to do.

/// The shortest text that reads back as `value`, whatever the locale.
inline std::string to_text(double value) {
    char text[32];
    return {text, std::to_chars(text, text + sizeof(text), value).ptr};
}

/// The mesh can not be processed.
struct InvalidInput : std::invalid_argument {
    using std::invalid_argument::invalid_argument;
};

/// An option is out of range, or does not fit the mesh.
struct InvalidOptions : std::invalid_argument {
    using std::invalid_argument::invalid_argument;
};

/// The progress callback asked to stop.
struct Cancelled : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// The requested compute device is missing or failed.
struct DeviceError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Memory was refused. Says so without allocating.
struct OutOfMemory : std::bad_alloc {
    const char* what() const noexcept override {
        return "There is not enough memory for this mesh; it was not changed. Close other programs "
               "or layers, simplify the mesh, or use a machine with more memory.";
    }
};

} // namespace spheroseg
