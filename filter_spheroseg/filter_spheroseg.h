// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "memory_return.h"
#include "prepared_mesh_cache.h"
#include "results.h"

#include <common/plugins/interfaces/filter_plugin.h>

#include <atomic>

/// The MeshLab plugin. Each filter reads the current mesh into plain arrays, calls the engine, and
/// writes the result only when nothing can fail any more.
class FilterSpheroSegPlugin : public QObject, public FilterPlugin {
    Q_OBJECT
    MESHLAB_PLUGIN_IID_EXPORTER(FILTER_PLUGIN_IID)
    Q_INTERFACES(FilterPlugin)

public:
    enum FilterId { SEGMENTATION, PARAMETRIZATION, MEASURES, LAYERS };

    FilterSpheroSegPlugin();

    QString pluginName() const override;
    QString vendor() const override;
    QString filterName(ActionIDType filter) const override;
    QString pythonFilterName(ActionIDType filter) const override;
    QString filterInfo(ActionIDType filter) const override;
    FilterClass getClass(const QAction* action) const override;
    FilterArity filterArity(const QAction* action) const override;
    int getPreConditions(const QAction* action) const override;
    int postCondition(const QAction* action) const override;
    RichParameterList initParameterList(const QAction* action,
                                        const MeshDocument& document) override;
    std::map<std::string, QVariant> applyFilter(const QAction* action,
                                                const RichParameterList& parameters,
                                                MeshDocument& document,
                                                unsigned int& post_condition_mask,
                                                vcg::CallBackPos* callback) override;

private:
    spheroseg::Results segment(MeshDocument& document,
                               const RichParameterList& parameters,
                               unsigned int& post_condition_mask,
                               const spheroseg::Progress& progress);
    spheroseg::Results parametrize(MeshDocument& document,
                                   const RichParameterList& parameters,
                                   const spheroseg::Progress& progress);
    spheroseg::Results measure(const MeshModel& model);
    spheroseg::Results generate_layers(MeshDocument& document, const spheroseg::Progress& progress);

    spheroseg::PreparedMeshCache cache_;
    spheroseg::MemoryReturn memory_return_;
    std::atomic<bool> running_{false};
};
