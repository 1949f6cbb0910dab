// Hunts scenes whose cells are wrong, refused, slow or too large: `hunt --seed 7 --count 1000 --save FOLDER`.
// Each scene's own seed is printed with its outcome, and gives the same scene again (`--seed K --count 1`).
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>

#include "../../io/files/scene_file.hpp"
#include "families.hpp"
#include "trial.hpp"

using namespace vcell;
using namespace vcell::hunt;

namespace {

struct Tally {
    std::array<unsigned, outcome_count> count{};

    unsigned total() const {
        unsigned sum = 0;
        for (const unsigned c : count) sum += c;
        return sum;
    }
    unsigned of(Outcome o) const { return count[static_cast<std::size_t>(o)]; }
    unsigned faults() const {
        unsigned sum = 0;
        for (std::size_t i = 0; i < outcome_count; ++i)
            if (is_fault(static_cast<Outcome>(i))) sum += count[i];
        return sum;
    }
    void add(const Tally& other) {
        for (std::size_t i = 0; i < outcome_count; ++i) count[i] += other.count[i];
    }
};

std::string row(const std::string& name, const Tally& t) {
    std::string line = fmt::format("{:<24}{:>9}", name, t.total());
    for (const unsigned c : t.count) line += fmt::format("{:>10}", c);
    return line + "\n";
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Hunts hostile scenes on which vcell fails.", "hunt");
    std::vector<std::string> names, bases;
    std::uint64_t seed = 1, count = 10;
    Limits limits;
    std::string folder;
    bool lists = false, minimises = false, is_quiet = false;
    double most_undecided = 100;
    app.add_option("--families", names, "names, separated by commas; default: all")->delimiter(',');
    app.add_option("--bases", bases, "plane, tilted-plane, ball, tube, tilted-tube; default: all")
        ->delimiter(',');
    app.add_option("--seed", seed, "of the first scene of each family and base")->capture_default_str();
    app.add_option("--count", count, "scenes for each family and base")->capture_default_str();
    app.add_option("--seconds", limits.seconds, "of processor time a scene may take")->capture_default_str();
    app.add_option("--megabytes", limits.megabytes, "of memory a scene may take")->capture_default_str();
    app.add_option("--save", folder, "folder for the scenes that are not proved");
    app.add_flag("--minimise", minimises, "shrink what is saved");
    app.add_option("--most-undecided", most_undecided,
                   "per cent of all scenes that may stay undecided, open or assumed")
        ->capture_default_str();
    app.add_flag("--quiet", is_quiet, "only the table");
    app.add_flag("--list", lists, "name the families");
    CLI11_PARSE(app, argc, argv);

    if (lists) {
        for (const Family& f : families()) fmt::print("{:<12}{}\n", f.name, f.about);
        return 0;
    }
    const auto is_chosen = [](const std::vector<std::string>& chosen, const std::string& name) {
        return chosen.empty() || std::ranges::find(chosen, name) != chosen.end();
    };
    if (!folder.empty()) std::filesystem::create_directories(folder);

    std::string table = fmt::format("{:<24}{:>9}", "family/base", "scenes");
    for (std::size_t i = 0; i < outcome_count; ++i)
        table += fmt::format("{:>10}", to_string(static_cast<Outcome>(i)));
    table += "\n";
    Tally sum;
    for (const Family& family : families()) {
        if (!is_chosen(names, family.name)) continue;
        for (const BaseKind base : base_kinds) {
            if (!is_chosen(bases, to_string(base))) continue;
            const std::string title = fmt::format("{}/{}", family.name, to_string(base));
            Tally tally;
            for (std::uint64_t k = seed; k < seed + count; ++k) {
                std::seed_seq seeds{static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(k >> 32)};
                std::mt19937_64 rng(seeds);
                Scene scene = family.make(rng, base);
                const Trial trial = judge(scene, limits);
                ++tally.count[static_cast<std::size_t>(trial.outcome)];
                if (trial.outcome == Outcome::Proved) continue;
                if (!is_quiet)
                    fmt::print("{} --seed {}: {}: {}\n", title, k, to_string(trial.outcome), trial.what);
                if (folder.empty()) continue;
                if (minimises) scene = minimised(std::move(scene), trial, limits);
                std::ofstream out(fmt::format("{}/{}_{}_{}.json", folder, family.name, to_string(base), k));
                write_scene(out, scene);
            }
            table += row(title, tally);
            sum.add(tally);
        }
    }
    table += row("all", sum);
    fmt::print("{}", table);
    if (sum.total() == 0) {
        fmt::print("no scene: no such family or base\n");
        return 1;
    }
    const double undecided =
        100.0 * (sum.of(Outcome::Undecided) + sum.of(Outcome::Open) + sum.of(Outcome::Assumed)) / sum.total();
    return sum.faults() == 0 && undecided <= most_undecided ? 0 : 4;
}
