#include "mpi_diagram.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <vector>

#include "../core/threads.hpp"
#include "../io/files/diagram_file.hpp"
#include "../io/pictures/mesh_formats.hpp"
#include "grid_file.hpp"
#include "meshed_cells.hpp"
#include "ordered.hpp"
#include "scene_parts.hpp"
#include "shared_cells.hpp"
#include "shared_file.hpp"
#include "surroundings.hpp"

namespace vcell::mpi {

namespace {

class Stopwatch {
public:
    /// Since the last call, or since this object was made.
    double seconds() {
        const Clock::time_point now = Clock::now();
        const double passed = std::chrono::duration<double>(now - begin_).count();
        begin_ = now;
        return passed;
    }

private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point begin_ = Clock::now();
};

struct Seconds {
    double spread = 0, rounds = 0, cells = 0, output = 0;
};

// What all ranks say, by the first one, in their order.
void warn_of(Ranks& ranks, const std::vector<std::string>& mine) {
    Letter letter;
    for (const std::string& text : mine) letter.put(text);
    std::vector<Letter> to(ranks.size());
    to[0] = std::move(letter);
    for (const Letter& all : ranks.exchange(std::move(to)))
        for (LetterReader in(all); !in.at_end();) warn(in.get<std::string>());
}

std::vector<DiagramCell> measured_cells(Ranks& ranks, const SceneParts& parts, Surroundings& around,
                                        unsigned threads) {
    if (around.are_sharing()) return shared_cells(ranks, parts, around, threads);
    std::vector<DiagramCell> cells(parts.own.size());
    ranks.together([&] {
        for_all(cells.size(), threads, [&](std::size_t i) {
            cells[i] = whole::find_cell(around.decided(), around.place(i), nullptr);
        });
    });
    return cells;
}

std::string cell_rows(Ranks& ranks, const OrderedCells& ordered) {
    std::ostringstream out;
    if (ranks.is_first()) write_cell_header(out);
    write_cell_rows(out, ordered.scene, ordered.cells, ordered.first);
    return std::move(out).str();
}

std::string contact_rows(Ranks& ranks, const OrderedCells& ordered) {
    std::ostringstream out;
    if (ranks.is_first()) write_contact_header(out);
    const auto place = [&](std::uint32_t number) {
        const auto at = std::ranges::lower_bound(ordered.paired_numbers, number);
        return static_cast<std::size_t>(at - ordered.paired_numbers.begin());
    };
    write_contact_rows(out, ordered.paired, place, ordered.contacts);
    return std::move(out).str();
}

std::string statistics_rows(Ranks& ranks, std::size_t own, const RoundStatistics& s,
                            std::uint64_t mesh_rounds, const Seconds& took) {
    std::string text;
    if (ranks.is_first())
        text =
            "rank\tobjects\trounds\tasking\tquestions\tghosts\treplicated\tbytes\tbytes_in_all\tmesh_rounds\tspread_s\t"
            "rounds_s\tcells_s\toutput_s\n";
    return text + fmt::format("{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{:.3f}\t{:.3f}\t{:.3f}\t{:.3f}\n",
                              ranks.rank(), own, s.rounds, s.asking, s.questions, s.ghosts, s.replicated,
                              s.bytes, ranks.bytes_sent(), mesh_rounds, took.spread, took.rounds, took.cells,
                              took.output);
}

}  // namespace

MpiDiagram::MpiDiagram(CLI::App& app) : command_(*app.add_subcommand("diagram", "the cells of all objects")) {
    scene_.add_path_to(command_);
    command_.add_option("--cells", cells_, "table of the cells, as vcell diagram writes it")
        ->type_name("FILE");
    command_.add_option("--contacts", contacts_, "table of the pairs of neighbours, likewise")
        ->type_name("FILE");
    command_
        .add_option("-o,--output", output_,
                    "all cells' boundaries, .vtkhdf, for ParaView: triangles with cell, neighbor and volume")
        ->type_name("FILE");
    chord_.add_to(command_);
    command_.add_option("--statistics", statistics_, "table of what each process asked, sent and took")
        ->type_name("FILE");
    scene_.add_to(command_);
    threads_.add_to(command_);
    command_.footer(
        "Run by mpirun. Files and standard output have the same bytes for any number of processes and threads.\n"
        "--threads is of each process. Exit statuses are vcell's.");
}

void MpiDiagram::check_output() const {
    if (output_.empty()) return;
    if (std::filesystem::path(output_).extension() != ".vtkhdf")
        throw UsageError(fmt::format("{}: an output must end in .vtkhdf", output_));
    if (!has_grid_files())
        throw UsageError(fmt::format(
            "{}: this program was built without a parallel HDF5 (Debian's package is libhdf5-openmpi-dev)",
            output_));
}

Status MpiDiagram::run(Ranks& ranks) const {
    Stopwatch clock;
    Seconds took;
    std::vector<std::string> targets;
    const auto open = [&](const std::string& name) -> std::unique_ptr<SharedFile> {
        if (name.empty()) return nullptr;
        ranks.together([&] {
            if (std::ranges::find(targets, name) != targets.end())
                throw UsageError(fmt::format("{}: given twice", name));
        });
        targets.push_back(name);
        return std::make_unique<SharedFile>(ranks, name);
    };
    const auto open_grid = [&] {
        ranks.together([&] { check_output(); });
        auto file = open(output_);
        if (file && file->hidden().empty())
            ranks.together([&] { throw UsageError(fmt::format("{}: a .vtkhdf is a file", output_)); });
        return file;
    };
    const auto cell_file = open(cells_), contact_file = open(contacts_), statistics_file = open(statistics_),
               grid_file = open_grid();
    const bool is_summary_shown = std::ranges::find(targets, "-") == targets.end();

    std::optional<DiagramScene> scene = ranks.together([&]() -> std::optional<DiagramScene> {
        if (!ranks.is_first()) return std::nullopt;
        return scene_.read();
    });
    const SceneParts parts = spread(ranks, std::move(scene), scene_.path());
    took.spread = clock.seconds();
    const unsigned threads = threads_.count();
    Surroundings around(ranks, parts, grid_file == nullptr, threads);
    took.rounds = clock.seconds();

    MeshedCells found;
    if (grid_file)
        found = meshed_cells(ranks, parts, around, chord_.part(), threads);
    else
        found.cells = measured_cells(ranks, parts, around, threads);
    took.cells = clock.seconds();
    const OrderedCells ordered = in_order(ranks, parts, std::move(found.cells));
    if (cell_file) cell_file->write(ranks.together([&] { return cell_rows(ranks, ordered); }));
    if (contact_file) contact_file->write(ranks.together([&] { return contact_rows(ranks, ordered); }));
    if (grid_file) write_grid(ranks, in_order(ranks, parts, ordered, std::move(found.meshes)), *grid_file);
    took.output = clock.seconds();
    if (statistics_file)
        statistics_file->write(
            statistics_rows(ranks, parts.own.size(), around.statistics(), found.rounds, took));
    const std::array files{cell_file.get(), contact_file.get(), statistics_file.get(), grid_file.get()};
    for (SharedFile* file : files)
        if (file != nullptr) file->close();
    for (SharedFile* file : files)
        if (file != nullptr) file->commit();
    return conclude(ranks, parts, ordered, is_summary_shown);
}

Status MpiDiagram::conclude(Ranks& ranks, const SceneParts& parts, const OrderedCells& ordered,
                            bool is_summary_shown) {
    using State = DiagramCell::State;
    std::uint64_t computed = 0, empty = 0, walls = 0, assumed = 0;
    std::vector<std::string> warnings;
    for (std::size_t i = 0; i < ordered.cells.size(); ++i) {
        const DiagramCell& cell = ordered.cells[i];
        assumed += cell.assumed;
        if (cell.state == State::Computed) ++computed;
        if (cell.state == State::Empty) ++empty;
        if (cell.state == State::Wall) ++walls;
        if (cell.state == State::Undecided || cell.state == State::Refused)
            warnings.push_back(
                fmt::format("no cell of object {}, the base here: {}", ordered.first + i, cell.reason));
    }
    warn_of(ranks, warnings);
    warn_of(ranks, ordered.faults);
    computed = ranks.sum(computed);
    empty = ranks.sum(empty);
    walls = ranks.sum(walls);
    assumed = ranks.sum(assumed);
    const std::uint64_t pairs = ranks.sum(static_cast<std::uint64_t>(ordered.contacts.size())),
                        faults = ranks.sum(static_cast<std::uint64_t>(ordered.faults.size()));
    const FilledVolume sum = filled_volume(ranks, parts, ordered);
    if (is_summary_shown && ranks.is_first())
        fmt::print(
            "cells\tempty\tcontacts\tvolume\tvolume_error\tbox\testimated\n{}\t{}\t{}\t{}\t{}\t{}\t{:d}\n",
            computed, empty, pairs, sum.volume, sum.error, sum.box, sum.is_estimated);
    const bool is_whole = computed + empty + walls == parts.count && faults == 0 && assumed == 0;
    if (ranks.is_first()) report_assumed(assumed);
    return is_whole ? done : undecided;
}

}  // namespace vcell::mpi
