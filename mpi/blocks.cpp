#include "blocks.hpp"

#include <Eigen/Geometry>

namespace vcell::mpi {

KdBlocks::KdBlocks(Ranks& ranks, const std::vector<Vec3>& points, std::uint64_t count) {
    // So many points for each block that its part of all balls is right to a few percent.
    const std::uint64_t wanted =
                            std::max<std::uint64_t>(1 << 16, 1024 * static_cast<std::uint64_t>(ranks.size())),
                        step = 1 + count / wanted;
    Letter mine;
    for (std::size_t i = 0; i < points.size(); i += step) mine.put(points[i]);
    std::vector<Vec3> sample;
    for (const Letter& letter : ranks.share(mine))
        for (LetterReader in(letter); !in.at_end();) sample.push_back(in.get<Vec3>());
    build(sample.begin(), sample.end(), 0, ranks.size());
}

void KdBlocks::build(std::vector<Vec3>::iterator begin, std::vector<Vec3>::iterator end, int first,
                     int last) {
    const std::size_t at = nodes_.size();
    nodes_.emplace_back();
    if (last - first == 1 || begin == end) {
        nodes_[at].rank = first;
        return;
    }
    Box box{*begin, *begin};
    for (auto p = begin; p != end; ++p) {
        box.min = box.min.cwiseMin(*p);
        box.max = box.max.cwiseMax(*p);
    }
    Eigen::Index longest;
    (box.max - box.min).maxCoeff(&longest);
    const int axis = static_cast<int>(longest), half = (last - first) / 2;
    const auto middle = begin + (end - begin) * half / (last - first);
    std::nth_element(begin, middle, end,
                     [axis](const Vec3& a, const Vec3& b) { return key(a, axis) < key(b, axis); });
    nodes_[at].axis = axis;
    nodes_[at].from = key(*middle, axis);
    build(begin, middle, first, first + half);
    nodes_[at].second = nodes_.size();
    build(middle, end, first + half, last);
}

int KdBlocks::rank_of(const Vec3& point) const {
    std::size_t at = 0;
    while (nodes_[at].rank < 0)
        at = key(point, nodes_[at].axis) < nodes_[at].from ? at + 1 : nodes_[at].second;
    return nodes_[at].rank;
}

BlockMap::BlockMap(Ranks& ranks, const whole::Lattice& lattice, const Block& mine) : lattice_(lattice) {
    Letter letter;
    letter.put(mine.centers.min);
    letter.put(mine.centers.max);
    letter.put(mine.largest);
    std::vector<BallTree::Entry> balls;
    for (const Letter& other : ranks.share(letter)) {
        LetterReader in(other);
        Block block;
        block.centers.min = in.get<Vec3>();
        block.centers.max = in.get<Vec3>();
        block.largest = in.get<double>();
        const auto rank = static_cast<int>(blocks_.size());
        blocks_.push_back(block);
        if (rank == ranks.rank() || block.largest < 0) continue;
        const Box& box = block.centers;
        balls.push_back({{0.5 * (box.min + box.max), 0.5 * box.diagonal() + block.largest},
                         static_cast<std::uint32_t>(rank)});
    }
    tree_ = BallTree(std::move(balls));
}

}  // namespace vcell::mpi
