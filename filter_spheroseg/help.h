// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Shown at the top of each filter's dialog and in PyMeshLab's documentation; basic HTML.
namespace spheroseg {

extern const char* const kSegmentationHelp;
extern const char* const kParametrizationHelp;
extern const char* const kMeasuresHelp;
extern const char* const kLayersHelp;

} // namespace spheroseg
