#include "shared_cells.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "../core/threads.hpp"

namespace vcell::mpi {

namespace {

using whole::GivenFace;

class SharedCells {
public:
    SharedCells(Ranks& ranks, const SceneParts& parts, Surroundings& around, unsigned threads)
        : ranks_(ranks),
          parts_(parts),
          around_(around),
          threads_(threads),
          cells_(parts.own.size()),
          shared_(parts.own.size()) {}

    std::vector<DiagramCell> operator()() {
        ranks_.together([&] { for_all(cells_.size(), threads_, [&](std::size_t i) { find(i); }); });
        share();
        complete();
        return std::move(cells_);
    }

private:
    void find(std::size_t i) {
        const whole::DecidedDiagram& decided = around_.decided();
        const std::uint32_t place = around_.place(i);
        if (!decided.hidden(place).empty()) {
            cells_[i] = whole::find_cell(decided, place, nullptr);
            return;
        }
        std::optional<whole::FoundCell>& known = around_.found(i);
        whole::FoundCell found =
            known ? *std::move(known)
                  : whole::find_sharing_cell(decided, place, whole::Neighborhood(decided, place));
        cells_[i] = std::move(found.cell);
        shared_[i] = std::move(found.shared);
    }

    // By ascending givers, of which each is one rank's, as one process shares them.
    void share() {
        std::vector<Letter> to(ranks_.size());
        std::vector<GivenFace> faces;
        for (std::size_t i = 0; i < cells_.size(); ++i)
            whole::add_given_faces(parts_.own[i].number, cells_[i], shared_[i], faces);
        for (const GivenFace& face : faces) to[around_.owner(face.contact.site.index)].put(face);
        faces.clear();
        for (const Letter& letter : ranks_.exchange(std::move(to)))
            for (LetterReader in(letter); !in.at_end();) faces.push_back(in.get<GivenFace>());
        std::ranges::stable_sort(faces, {}, &GivenFace::giver);
        for (const GivenFace& face : faces) {
            const auto taker =
                std::ranges::lower_bound(parts_.own, face.contact.site.index, {}, &OwnObject::number);
            const auto i = static_cast<std::size_t>(taker - parts_.own.begin());
            if (shared_[i].is_sharing) whole::take(face, cells_[i]);
        }
    }

    // Cells that nobody gives what they lack measure it themselves, or are found anew.
    void complete() {
        std::vector<std::size_t> lacking;
        for (std::size_t i = 0; i < cells_.size(); ++i)
            if (shared_[i].is_sharing && whole::lacks_faces(cells_[i])) lacking.push_back(i);
        std::vector<char> is_complete(lacking.size());
        ranks_.together([&] {
            for_all(lacking.size(), threads_, [&](std::size_t k) {
                const std::size_t i = lacking[k];
                is_complete[k] = whole::complete_ball_cell(around_.decided(), around_.place(i), cells_[i]);
            });
        });
        std::vector<std::size_t> anew;
        for (std::size_t k = 0; k < lacking.size(); ++k)
            if (is_complete[k] == 0) anew.push_back(lacking[k]);
        if (ranks_.sum(static_cast<std::uint64_t>(anew.size())) == 0) return;
        around_.settle_bounds(anew);
        ranks_.together([&] {
            for_all(anew.size(), threads_, [&](std::size_t k) {
                cells_[anew[k]] = whole::find_cell(around_.decided(), around_.place(anew[k]), nullptr);
            });
        });
    }

    Ranks& ranks_;
    const SceneParts& parts_;
    Surroundings& around_;
    const unsigned threads_;
    std::vector<DiagramCell> cells_;
    std::vector<whole::SharedParts> shared_;
};

}  // namespace

std::vector<DiagramCell> shared_cells(Ranks& ranks, const SceneParts& parts, Surroundings& around,
                                      unsigned threads) {
    return SharedCells(ranks, parts, around, threads)();
}

}  // namespace vcell::mpi
