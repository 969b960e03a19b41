# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's comparison as a report: our methods, METIS and region growing on any meshes."""
