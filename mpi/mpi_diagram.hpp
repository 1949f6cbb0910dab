/// vcell-mpi diagram: the cells of all objects, by many processes.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "../apps/chord_argument.hpp"
#include "../apps/diagram_scene_arguments.hpp"
#include "../apps/threads_argument.hpp"
#include "ordered.hpp"
#include "ranks.hpp"
#include "scene_parts.hpp"

namespace vcell::mpi {

class MpiDiagram {
public:
    explicit MpiDiagram(CLI::App& app);

    /// On all ranks. Throws SharedFailure.
    Status run(Ranks& ranks) const;

private:
    void check_output() const;
    static Status conclude(Ranks& ranks, const SceneParts& parts, const OrderedCells& ordered,
                           bool is_summary_shown);

    CLI::App& command_;
    DiagramSceneArguments scene_;
    std::string cells_, contacts_, output_, statistics_;
    ChordArgument chord_;
    ThreadsArgument threads_{"1"};
};

}  // namespace vcell::mpi
