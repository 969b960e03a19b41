// SPDX-License-Identifier: GPL-3.0-or-later
#include "new_layers.h"

namespace spheroseg {

NewLayers::NewLayers(MeshDocument& document) : document_(document), current_(document.mm()->id()) {}

NewLayers::~NewLayers() {
    if (is_kept_ || ids_.empty()) {
        return;
    }
    for (int id : ids_) {
        document_.delMesh(id);
    }
    document_.setCurrentMesh(current_); // removing a layer makes another one current
}

MeshModel& NewLayers::add(const QString& name) {
    ids_.push_back(-1); // no layer's id; nothing may fail when there is one
    MeshModel& layer = *document_.addNewMesh(QString(), name, false);
    ids_.back() = layer.id();
    return layer;
}

} // namespace spheroseg
