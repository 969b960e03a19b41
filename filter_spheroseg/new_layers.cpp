// SPDX-License-Identifier: GPL-3.0-or-later
#include "new_layers.h"

#include <QApplication>
#include <QThread>
#include <QWidget>

namespace spheroseg {

namespace {

/// Null where there is none, as in PyMeshLab.
QWidget* visible_layer_list() {
    const auto* application = qobject_cast<QApplication*>(QCoreApplication::instance());
    if (!application || application->thread() != QThread::currentThread()) {
        return nullptr;
    }
    for (const QWidget* window : QApplication::topLevelWidgets()) {
        auto* list = window->findChild<QWidget*>("layerDialog");
        if (list && list->isVisible()) {
            return list;
        }
    }
    return nullptr;
}

} // namespace

NewLayers::NewLayers(MeshDocument& document) : document_(document), current_(document.mm()->id()) {}

NewLayers::~NewLayers() {
    if (!is_kept_ && !ids_.empty()) {
        for (int id : ids_) {
            document_.delMesh(id);
        }
        document_.setCurrentMesh(current_); // removing a layer makes another one current
    }
    if (hidden_list_) {
        // Later, as MeshLab builds it several times at the end of a filter, too.
        QMetaObject::invokeMethod(hidden_list_, "show", Qt::QueuedConnection);
    }
}

MeshModel& NewLayers::add(const QString& name) {
    if (ids_.size() == 1) {
        hidden_list_ = visible_layer_list();
        if (hidden_list_) {
            hidden_list_->hide();
        }
    }
    ids_.push_back(-1); // no layer's id; nothing may fail when there is one
    MeshModel& layer = *document_.addNewMesh(QString(), name, false);
    ids_.back() = layer.id();
    return layer;
}

} // namespace spheroseg
