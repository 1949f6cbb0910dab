#include "ordered.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "../envelope/whole/own_periods.hpp"
#include "../envelope/whole/totals.hpp"

namespace vcell::mpi {

namespace {

// What pairs must know of an object that is in another range.
struct Neighbor {
    Object object;
    std::string name;
    bool is_known;  // whole::pair_up()
};

void take_cells(Ranks& ranks, const SceneParts& parts, std::vector<DiagramCell> cells,
                OrderedCells& ordered) {
    std::vector<Letter> to(ranks.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const OwnObject& own = parts.own[i];
        Letter& letter = to[range_of(own.number, ranks.size(), parts.count)];
        letter.put(own.number);
        letter.put(own.given);
        letter.put(own.name);
        letter.put(own.group);
        letter.put(cells[i]);
        cells[i] = {};
    }
    ordered.first = range_begin(ranks.rank(), ranks.size(), parts.count);
    const std::uint32_t count = range_begin(ranks.rank() + 1, ranks.size(), parts.count) - ordered.first;
    ordered.scene = parts.given_frame;
    ordered.scene.objects.resize(count);
    ordered.scene.names.resize(count);
    ordered.scene.groups.resize(count);
    ordered.cells.resize(count);
    for (const Letter& letter : ranks.exchange(std::move(to)))
        for (LetterReader in(letter); !in.at_end();) {
            const std::uint32_t i = in.get<std::uint32_t>() - ordered.first;
            ordered.scene.objects[i] = in.get<Object>();
            ordered.scene.names[i] = in.get<std::string>();
            ordered.scene.groups[i] = in.get<std::string>();
            ordered.cells[i] = in.get<DiagramCell>();
        }
}

// VoronoiDiagram::periods: each process knows all objects that are no balls.
std::vector<ObjectImage> periods_of_others(const SceneParts& parts) {
    const whole::Lattice lattice(parts.frame);
    std::vector<ObjectImage> all;
    for (const KnownObject& other : parts.others) {
        const auto periods = whole::own_periods(lattice, other.object);
        for (const whole::Image& period : *periods) all.push_back({other.number, period});
    }
    return all;
}

// Sides of pairs go where their first objects are.
std::vector<whole::ContactSide> take_sides(Ranks& ranks, const SceneParts& parts,
                                           const OrderedCells& ordered) {
    const std::vector<ObjectImage> periods = periods_of_others(parts);
    std::vector<Letter> to(ranks.size());
    for (std::size_t i = 0; i < ordered.cells.size(); ++i)
        for (const CellContact& contact : ordered.cells[i].contacts) {
            const whole::ContactSide side =
                whole::contact_side(ordered.first + static_cast<std::uint32_t>(i), contact, periods);
            to[range_of(side.first, ranks.size(), parts.count)].put(side);
        }
    std::vector<whole::ContactSide> sides;
    for (const Letter& letter : ranks.exchange(std::move(to)))
        for (LetterReader in(letter); !in.at_end();) sides.push_back(in.get<whole::ContactSide>());
    return sides;
}

std::map<std::uint32_t, Neighbor> look_up(Ranks& ranks, const SceneParts& parts, const OrderedCells& ordered,
                                          const std::vector<whole::ContactSide>& sides) {
    std::set<std::uint32_t> numbers;
    for (const whole::ContactSide& side : sides) {
        numbers.insert(side.first);
        if (side.second.is_object()) numbers.insert(side.second.index);
    }
    std::vector<Letter> asked(ranks.size()), told(ranks.size());
    for (const std::uint32_t number : numbers) asked[range_of(number, ranks.size(), parts.count)].put(number);
    const std::vector<Letter> got = ranks.exchange(std::move(asked));
    for (int rank = 0; rank < ranks.size(); ++rank)
        for (LetterReader in(got[rank]); !in.at_end();) {
            const auto number = in.get<std::uint32_t>();
            const std::size_t i = number - ordered.first;
            told[rank].put(number);
            told[rank].put(ordered.scene.objects[i]);
            told[rank].put(ordered.scene.names[i]);
            told[rank].put(whole::knows_contacts(ordered.cells[i]));
        }
    std::map<std::uint32_t, Neighbor> neighbors;
    for (const Letter& letter : ranks.exchange(std::move(told)))
        for (LetterReader in(letter); !in.at_end();) {
            const auto number = in.get<std::uint32_t>();
            Neighbor neighbor;
            neighbor.object = in.get<Object>();
            neighbor.name = in.get<std::string>();
            neighbor.is_known = in.get<bool>();
            neighbors.emplace(number, std::move(neighbor));
        }
    return neighbors;
}

}  // namespace

OrderedCells in_order(Ranks& ranks, const SceneParts& parts, std::vector<DiagramCell> cells) {
    OrderedCells ordered;
    take_cells(ranks, parts, std::move(cells), ordered);
    std::vector<whole::ContactSide> sides = take_sides(ranks, parts, ordered);
    const std::map<std::uint32_t, Neighbor> neighbors = look_up(ranks, parts, ordered, sides);
    ContactTable table =
        whole::pair_up(std::move(sides), [&](std::uint32_t number) { return neighbors.at(number).is_known; });
    ordered.contacts = std::move(table.contacts);
    ordered.faults = std::move(table.faults);
    ordered.paired = parts.given_frame;
    for (const auto& [number, neighbor] : neighbors) {
        ordered.paired_numbers.push_back(number);
        ordered.paired.objects.push_back(neighbor.object);
        ordered.paired.names.push_back(neighbor.name);
    }
    return ordered;
}

FilledVolume filled_volume(Ranks& ranks, const SceneParts& parts, const OrderedCells& ordered) {
    // One range after the other, as one process adds them: the sum of parts would be another double.
    whole::VolumeSum sum(parts.given_frame, parts.moved);
    const auto pass = [&](int to) {
        MPI_Send(&sum.so_far, sizeof(FilledVolume), MPI_BYTE, to, 0, ranks.all());
    };
    const auto take = [&](int from) {
        MPI_Recv(&sum.so_far, sizeof(FilledVolume), MPI_BYTE, from, 0, ranks.all(), MPI_STATUS_IGNORE);
    };
    static_assert(std::is_trivially_copyable_v<FilledVolume>);
    if (ranks.rank() > 0) take(ranks.rank() - 1);
    sum.add(ordered.cells);
    if (ranks.rank() + 1 < ranks.size()) pass(ranks.rank() + 1);
    if (ranks.size() > 1) {
        if (ranks.rank() + 1 == ranks.size()) pass(0);
        if (ranks.is_first()) take(ranks.size() - 1);
    }
    return sum.of(parts.count);
}

}  // namespace vcell::mpi
