#include "scene_parts.hpp"

#include <algorithm>

#include "../envelope/whole/cell_finder.hpp"
#include "blocks.hpp"

namespace vcell::mpi {

namespace {

void put_frame(Letter& letter, const DiagramScene& scene) {
    letter.put(scene.box.min);
    letter.put(scene.box.max);
    letter.put(scene.periodic);
    letter.put(scene.tilt);
    letter.put(scene.probe.has_value());
    letter.put(scene.probe.value_or(0));
    letter.put(scene.units);
    letter.put(scene.tolerance.has_value());
    letter.put(scene.tolerance.value_or(0));
}

DiagramScene get_frame(LetterReader& in) {
    DiagramScene scene;
    scene.box.min = in.get<Vec3>();
    scene.box.max = in.get<Vec3>();
    scene.periodic = in.get<std::array<bool, 3>>();
    scene.tilt = in.get<std::array<double, 3>>();
    const auto optional = [&]() -> std::optional<double> {
        const bool is_there = in.get<bool>();
        const auto value = in.get<double>();
        return is_there ? std::optional(value) : std::nullopt;
    };
    scene.probe = optional();
    scene.units = in.get<std::string>();
    scene.tolerance = optional();
    return scene;
}

std::string text_at(const std::vector<std::string>& texts, std::size_t i) {
    return i < texts.size() ? texts[i] : std::string();
}

}  // namespace

SceneParts spread(Ranks& ranks, std::optional<DiagramScene> scene, const std::string& path) {
    DiagramScene given = scene ? std::move(*scene) : DiagramScene(), snapped;
    Letter frame;
    ranks.together([&] {
        if (!ranks.is_first()) return;
        about_file(path, "", [&] { whole::validate_diagram(given); });
        snapped = given;
        const double moved = whole::snap_to_grid(snapped);
        put_frame(frame, snapped);
        put_frame(frame, given);
        frame.put(static_cast<std::uint32_t>(given.objects.size()));
        frame.put(moved);
        frame.put(!given.names.empty());
    });
    SceneParts parts;
    const Letter agreed = ranks.broadcast(std::move(frame), 0);
    LetterReader in(agreed);
    parts.frame = get_frame(in);
    parts.given_frame = get_frame(in);
    parts.count = in.get<std::uint32_t>();
    parts.moved = in.get<double>();
    parts.has_names = in.get<bool>();

    std::vector<Vec3> centers;
    for (const Object& object : snapped.objects)
        if (const auto* ball = std::get_if<Sphere>(&object)) centers.push_back(ball->center);
    const KdBlocks blocks(ranks, centers, ranks.sum(static_cast<std::uint64_t>(centers.size())));
    std::vector<Letter> to(ranks.size());
    Letter others;
    std::size_t next = 0;
    for (std::uint32_t i = 0; i < snapped.objects.size(); ++i) {
        const Object& object = snapped.objects[i];
        const std::string name = text_at(given.names, i);
        int rank = 0;
        if (const auto* ball = std::get_if<Sphere>(&object)) {
            rank = blocks.rank_of(ball->center);
        } else {
            rank = rank_of_other(next++, ranks.size());
            others.put(i);
            others.put(object);
            others.put(name);
        }
        to[rank].put(i);
        to[rank].put(object);
        to[rank].put(given.objects[i]);
        to[rank].put(name);
        to[rank].put(text_at(given.groups, i));
    }
    given = snapped = {};
    const std::vector<Letter> got = ranks.exchange(std::move(to));
    for (const Letter& letter : got)
        for (LetterReader reader(letter); !reader.at_end();) {
            OwnObject own;
            own.number = reader.get<std::uint32_t>();
            own.object = reader.get<Object>();
            own.given = reader.get<Object>();
            own.name = reader.get<std::string>();
            own.group = reader.get<std::string>();
            parts.own.push_back(std::move(own));
        }
    std::ranges::sort(parts.own, {}, &OwnObject::number);
    const Letter everywhere = ranks.broadcast(std::move(others), 0);
    for (LetterReader reader(everywhere); !reader.at_end();) {
        KnownObject known;
        known.number = reader.get<std::uint32_t>();
        known.object = reader.get<Object>();
        known.name = reader.get<std::string>();
        parts.others.push_back(std::move(known));
    }
    return parts;
}

std::uint32_t range_begin(int rank, int ranks, std::uint32_t count) {
    return static_cast<std::uint32_t>(static_cast<std::uint64_t>(count) * static_cast<std::uint64_t>(rank) /
                                      static_cast<std::uint64_t>(ranks));
}

int range_of(std::uint32_t number, int ranks, std::uint32_t count) {
    // The last rank whose range does not begin beyond the number.
    int rank = static_cast<int>(static_cast<std::uint64_t>(number) * static_cast<std::uint64_t>(ranks) /
                                std::max<std::uint32_t>(count, 1));
    while (rank + 1 < ranks && range_begin(rank + 1, ranks, count) <= number) ++rank;
    return rank;
}

}  // namespace vcell::mpi
