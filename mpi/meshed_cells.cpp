#include "meshed_cells.hpp"

#include <algorithm>
#include <functional>
#include <queue>
#include <unordered_map>
#include <utility>

#include "../core/threads.hpp"
#include "../envelope/whole/complete_cells.hpp"
#include "../io/pictures/conforming_meshes.hpp"
#include "mesh_letters.hpp"

namespace vcell::mpi {

namespace {

class Drawing {
public:
    Drawing(Ranks& ranks, const SceneParts& parts, const Surroundings& around, double chord, unsigned threads)
        : ranks_(ranks),
          parts_(parts),
          around_(around),
          threads_(threads),
          store_(around.decided(), parts.count, chord),
          result_{std::vector<DiagramCell>(parts.own.size()),
                  std::vector<std::optional<LabelledMesh>>(parts.own.size()), 0},
          met_(parts.own.size()),
          has_faces_(parts.own.size(), 0),
          waits_for_(parts.own.size(), 0) {}

    MeshedCells operator()() {
        measure();
        find_neighbors();
        for (std::size_t i = 0; i < parts_.own.size(); ++i)
            if (has_faces_[i] != 0 && waits_for_[i] == 0) ready_.push(i);
        auto left = static_cast<std::uint64_t>(std::ranges::count(has_faces_, 1));
        for (; ranks_.sum(left) > 0; ++result_.rounds) {
            std::vector<Letter> told(ranks_.size());
            ranks_.together([&] { left -= draw_ready(told); });
            const std::vector<Letter> got = ranks_.exchange(std::move(told));
            ranks_.together([&] { learn_from(got); });
        }
        return std::move(result_);
    }

private:
    void measure() {
        ranks_.together([&] {
            for_all(parts_.own.size(), threads_, [&](std::size_t i) {
                whole::WholeCells found = whole::find_whole_cells(around_.decided(), around_.place(i));
                result_.cells[i] = std::move(found.measured);
                has_faces_[i] = found.cells.empty() ? 0 : 1;
                for (const Cell& cell : found.cells) {
                    const std::vector<std::uint32_t> met = objects_met(cell);
                    met_[i].insert(met_[i].end(), met.begin(), met.end());
                }
            });
        });
    }

    // An object and those that its cell meets, or that meet it, come to know each other, if they have cells
    // with faces.
    void find_neighbors() {
        std::vector<Letter> to(ranks_.size());
        const auto tell = [&](std::uint32_t own, std::uint32_t other) {
            Letter& letter = to[around_.owner(other)];
            letter.put(other);
            letter.put(own);
        };
        for (std::size_t i = 0; i < parts_.own.size(); ++i)
            for (const std::uint32_t other : std::exchange(met_[i], {}))
                if (other != parts_.own[i].number) tell(parts_.own[i].number, other);
        for (const bool is_answered : {false, true}) {
            const std::vector<Letter> got =
                ranks_.exchange(std::exchange(to, std::vector<Letter>(ranks_.size())));
            for (const Letter& letter : got)
                for (LetterReader in(letter); !in.at_end();) {
                    const auto own = in.get<std::uint32_t>(), other = in.get<std::uint32_t>();
                    const std::size_t i = own_place(own);
                    if (has_faces_[i] == 0) continue;
                    met_[i].push_back(other);
                    if (!is_answered) tell(own, other);
                }
        }
        for (std::size_t i = 0; i < parts_.own.size(); ++i) {
            std::ranges::sort(met_[i]);
            met_[i].erase(std::ranges::unique(met_[i]).begin(), met_[i].end());
            for (const std::uint32_t other : met_[i]) {
                if (other > parts_.own[i].number) break;
                waiting_for_[other].push_back(i);
                ++waits_for_[i];
            }
        }
    }
    std::size_t own_place(std::uint32_t number) const {
        return static_cast<std::size_t>(std::ranges::lower_bound(parts_.own, number, {}, &OwnObject::number) -
                                        parts_.own.begin());
    }
    void has_come(std::uint32_t number) {
        const auto waiting = waiting_for_.find(number);
        if (waiting == waiting_for_.end()) return;
        for (const std::size_t i : waiting->second)
            if (--waits_for_[i] == 0) ready_.push(i);
        waiting_for_.erase(waiting);
    }

    // Draws until all that is left waits for other ranks. Returns how many cells.
    std::size_t draw_ready(std::vector<Letter>& told) {
        const std::size_t at_a_time = 16 * static_cast<std::size_t>(threads_);
        std::size_t drawn = 0;
        while (!ready_.empty()) {
            std::vector<std::size_t> some;
            for (; !ready_.empty() && some.size() < at_a_time; ready_.pop()) some.push_back(ready_.top());
            std::vector<std::vector<Cell>> cells(some.size());
            for_all(some.size(), threads_, [&](std::size_t k) {
                cells[k] = whole::find_whole_cells(around_.decided(), around_.place(some[k])).cells;
            });
            for (std::size_t k = 0; k < some.size(); ++k) draw(some[k], cells[k], told);
            drawn += some.size();
        }
        return drawn;
    }

    void draw(std::size_t i, const std::vector<Cell>& cells, std::vector<Letter>& told) {
        const std::uint32_t number = parts_.own[i].number;
        const std::vector<CellMesh> meshes = store_.add(number, cells);
        LabelledMesh& all = result_.meshes[i].emplace();
        for (std::size_t k = 0; k < cells.size(); ++k) {
            constexpr std::size_t any_colour = 0;
            all.add(static_cast<std::int32_t>(number), cells[k], meshes[k], any_colour);
        }
        all.normals = {};
        all.corner_normals = {};
        std::vector<bool> is_to(ranks_.size());
        for (const std::uint32_t other : met_[i])
            if (other > number) is_to[around_.owner(other)] = true;
        is_to[ranks_.rank()] = false;
        Letter letter;
        put_additions(letter, store_.take_additions());
        for (int rank = 0; rank < ranks_.size(); ++rank)
            if (is_to[rank]) told[rank].put(letter);
        has_come(number);
    }

    void learn_from(const std::vector<Letter>& got) {
        for (const Letter& letter : got)
            for (LetterReader in(letter); !in.at_end();) {
                const shared::Additions additions = get_additions(in);
                store_.learn(additions);
                has_come(additions.object);
            }
    }

    Ranks& ranks_;
    const SceneParts& parts_;
    const Surroundings& around_;
    const unsigned threads_;
    ScatteredMeshes store_;
    MeshedCells result_;
    std::vector<std::vector<std::uint32_t>> met_;  // of own objects: others that have cells, ascending
    std::vector<char> has_faces_;
    std::vector<std::size_t> waits_for_;                                       // so many of these
    std::unordered_map<std::uint32_t, std::vector<std::size_t>> waiting_for_;  // who does
    std::priority_queue<std::size_t, std::vector<std::size_t>, std::greater<>> ready_;
};

}  // namespace

MeshedCells meshed_cells(Ranks& ranks, const SceneParts& parts, const Surroundings& around, double chord,
                         unsigned threads) {
    return Drawing(ranks, parts, around, chord, threads)();
}

}  // namespace vcell::mpi
