/// What a rank must know of the others' balls to compute the cells of its own.
///
/// What is looked at for a cell is a matter of the cell alone. A cell is certain here where no other rank's
/// block may hold any of it. The others ask:
///
///   1. whom another block comes nearer than the last competitor known here, for that block's nearest balls.
///      The nearest of all are then among what is known;
///   2. where all objects are balls and cells are only measured (envelope/whole/ball_cell.hpp): the search of
///      the cell is tried among what is known, and asks, one after the other, for the shells that other
///      blocks may hold balls of. The marks go with the question, so the block answers with what a search
///      among all balls would have found there. The cell is found when no shell is left;
///   3. of all other cells: where the bound of few competitors (envelope/whole/cell_bound.hpp) is poor, for
///      many nearest balls, likewise; and whose bound another block may touch, for its balls that may. The
///      bound's competitors go with the question.
///
/// Every rank asks for all its cells at once, and until no cell of any rank has a question. A ball is sent to
/// a rank once. Balls so large that they would have every cell ask their block are known everywhere, as are
/// planes, tubes and vessels. The cells of those, and of balls centred outside a box that does not repeat,
/// are found among all objects: their ranks are sent everything.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <unordered_set>
#include <vector>

#include "../envelope/whole/ball_cell.hpp"
#include "blocks.hpp"
#include "scene_parts.hpp"

namespace vcell::mpi {

/// What it took, on this rank.
struct RoundStatistics {
    std::uint64_t rounds = 0;      ///< with a question of some rank
    std::uint64_t asking = 0;      ///< cells that asked
    std::uint64_t questions = 0;   ///< of a cell to a block
    std::uint64_t ghosts = 0;      ///< other ranks' balls that are known in the end
    std::uint64_t replicated = 0;  ///< large balls, planes, tubes and vessels
    std::uint64_t bytes = 0;  ///< that this rank sent to others, from the first question to the last answer
};

class Surroundings {
public:
    /// All rounds. `parts` must outlive this object. If cells are only measured, they may share faces.
    Surroundings(Ranks& ranks, const SceneParts& parts, bool are_measured, unsigned threads);

    /// The scene as far as it is known, in which the cells of own objects can be found: all that find_cell()
    /// asks for is there.
    const whole::DecidedDiagram& decided() const { return *decided_; }
    /// Where the own object of that place is among decided()'s.
    std::uint32_t place(std::size_t own) const { return places_[own]; }
    /// Do cells share faces, as whole::find_sharing_cell() has them?
    bool are_sharing() const { return are_sharing_; }
    /// Such a cell, if it was found on the way.
    std::optional<whole::FoundCell>& found(std::size_t own) { return found_[own]; }
    /// The rank that has an object that is known.
    int owner(std::uint32_t number) const;
    /// More rounds: then find_cell() will do of these own objects, too.
    void settle_bounds(const std::vector<std::size_t>& own);
    const RoundStatistics& statistics() const { return statistics_; }

private:
    /// What has been asked: nothing, for few competitors, for many, all.
    enum class Step : std::uint8_t { Begin, Few, Many, Certain };
    struct Question;

    bool is_ball(std::size_t own) const { return std::holds_alternative<Sphere>(parts_.own[own].object); }
    const Sphere& ball(std::size_t own) const { return std::get<Sphere>(parts_.own[own].object); }
    void learn(KnownObject known, int from);
    void learn_others();
    void replicate_large_balls();
    BlockMap block_map() const;
    void find_hidden();
    void forget_hidden();
    void send_everything();
    void settle();
    whole::ScenePart known_part();
    void rebuild();
    std::vector<Question> questions_of(std::size_t own);
    void search(std::size_t own, std::vector<Question>& questions);
    std::uint64_t ask();
    void put_ball(Letter& letter, int to, std::size_t own);
    std::vector<Letter> answers(const std::vector<Letter>& asked);
    void learn_from(const std::vector<Letter>& letters);

    Ranks& ranks_;
    const SceneParts& parts_;
    const unsigned threads_;
    whole::Lattice lattice_;
    std::vector<bool> is_large_;       // of own objects
    std::vector<std::string> hidden_;  // of own objects
    struct Known : KnownObject {
        int from;  // the rank that has it
    };
    std::map<std::uint32_t, Known> known_;  // of others' objects: large balls, ghosts; all that are no balls
    std::vector<std::unordered_set<std::uint32_t>> sent_;  // for each rank, places of own objects
    whole::ImageTree offered_;  // own balls that are not large, nor, after forget_hidden(), hidden
    BlockMap blocks_;
    std::uint64_t balls_ = 0;      // of all ranks that are not hidden
    std::vector<Step> steps_;      // of own objects
    std::vector<char> has_asked_;  // of own objects
    const bool are_sharing_;
    std::vector<char> is_searched_;  // of own objects: found_ is final
    std::vector<std::optional<whole::FoundCell>> found_;
    std::vector<std::size_t> answered_;  // of own objects: searches that are certain
    bool knows_everything_ = false;
    std::optional<whole::DecidedDiagram> decided_;
    std::vector<std::uint32_t> places_;
    RoundStatistics statistics_;
};

}  // namespace vcell::mpi
