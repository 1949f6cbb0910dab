/// A hunt: what becomes of many scenes of some families, in a table.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "trial.hpp"

namespace vcell::hunt {

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
    void add(Outcome o) { ++count[static_cast<std::size_t>(o)]; }
    void add(const Tally& other) {
        for (std::size_t i = 0; i < outcome_count; ++i) count[i] += other.count[i];
    }
};

inline std::string row(const std::string& name, const Tally& t) {
    std::string line = fmt::format("{:<24}{:>9}", name, t.total());
    for (const unsigned c : t.count) line += fmt::format("{:>10}", c);
    return line + "\n";
}

class Campaign {
public:
    /// `kinds` are what each family is made in: the option's name, the word for one, and their names.
    struct Kinds {
        std::string option, one, names;
    };
    Campaign(CLI::App& app, Kinds kinds) : kinds_(std::move(kinds)) {
        app.add_option("--families", families_, "names, separated by commas; default: all")->delimiter(',');
        app.add_option("--" + kinds_.option, chosen_kinds_, kinds_.names + "; default: all")->delimiter(',');
        app.add_option("--seed", seed_, "of the first scene of each family and " + kinds_.one)
            ->capture_default_str();
        app.add_option("--count", count_, "scenes for each family and " + kinds_.one)->capture_default_str();
        app.add_option("--seconds", limits_.seconds, "of processor time a scene may take")
            ->capture_default_str();
        app.add_option("--megabytes", limits_.megabytes, "of memory a scene may take")->capture_default_str();
        app.add_option("--save", folder_, "folder for the scenes that are not proved");
        app.add_flag("--minimise", minimises_, "shrink what is saved");
        app.add_option("--most-undecided", most_undecided_,
                       "per cent of all scenes that may stay undecided, open or assumed")
            ->capture_default_str();
        app.add_flag("--quiet", is_quiet_, "only the table");
        app.add_flag("--list", lists_, "name the families");
    }

    /// `write` puts a scene into a stream. Returns the program's exit code.
    template <class Families, class KindsOf, class Write>
    int run(const Families& families, const KindsOf& kinds, const Write& write) {
        if (lists_) {
            for (const auto& f : families) fmt::print("{:<12}{}\n", f.name, f.about);
            return 0;
        }
        if (!folder_.empty()) std::filesystem::create_directories(folder_);
        std::string table = fmt::format("{:<24}{:>9}", "family/" + kinds_.one, "scenes");
        for (std::size_t i = 0; i < outcome_count; ++i)
            table += fmt::format("{:>10}", to_string(static_cast<Outcome>(i)));
        table += "\n";
        Tally sum;
        for (const auto& family : families) {
            if (!is_chosen(families_, family.name)) continue;
            for (const auto kind : kinds) {
                if (!is_chosen(chosen_kinds_, to_string(kind))) continue;
                Tally tally;
                for (std::uint64_t k = seed_; k < seed_ + count_; ++k)
                    tally.add(outcome_of(family, kind, k, write));
                table += row(fmt::format("{}/{}", family.name, to_string(kind)), tally);
                sum.add(tally);
            }
        }
        table += row("all", sum);
        fmt::print("{}", table);
        if (sum.total() == 0) {
            fmt::print("no scene: no such family or {}\n", kinds_.one);
            return 1;
        }
        const double undecided =
            100.0 * (sum.of(Outcome::Undecided) + sum.of(Outcome::Open) + sum.of(Outcome::Assumed)) /
            sum.total();
        return sum.faults() == 0 && undecided <= most_undecided_ ? 0 : 4;
    }

private:
    static bool is_chosen(const std::vector<std::string>& chosen, const std::string& name) {
        return chosen.empty() || std::ranges::find(chosen, name) != chosen.end();
    }
    template <class Family, class Kind, class Write>
    Outcome outcome_of(const Family& family, Kind kind, std::uint64_t seed, const Write& write) const {
        std::seed_seq seeds{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)};
        std::mt19937_64 rng(seeds);
        auto scene = family.make(rng, kind);
        const Trial trial = judge(scene, limits_);
        if (trial.outcome == Outcome::Proved) return trial.outcome;
        if (!is_quiet_)
            fmt::print("{}/{} --seed {}: {}: {}\n", family.name, to_string(kind), seed,
                       to_string(trial.outcome), trial.what);
        if (folder_.empty()) return trial.outcome;
        if (minimises_) scene = minimised(std::move(scene), trial, limits_);
        std::ofstream out(fmt::format("{}/{}_{}_{}.json", folder_, family.name, to_string(kind), seed));
        write(out, scene);
        return trial.outcome;
    }

    const Kinds kinds_;
    std::vector<std::string> families_, chosen_kinds_;
    std::uint64_t seed_ = 1, count_ = 10;
    Limits limits_;
    std::string folder_;
    bool lists_ = false, minimises_ = false, is_quiet_ = false;
    double most_undecided_ = 100;
};

}  // namespace vcell::hunt
