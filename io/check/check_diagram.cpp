#include "check_diagram.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <variant>

#include "../../core/errors.hpp"
#include "../../core/numbers/exact.hpp"
#include "../../core/numbers/interval.hpp"
#include "../../core/threads.hpp"

namespace vcell {

namespace {

// Numbers of a file are rounded (check.hpp).
constexpr double file_rounding = 0x1p-44;

std::string cell_name(std::uint32_t object) { return fmt::format("cells[{}]", object); }

// Balls in cubes, each listed where its centre is.
class Grid {
public:
    explicit Grid(const std::vector<Sphere>& balls) : balls_(balls) {
        Vec3 low = balls[0].center, high = balls[0].center;
        for (const Sphere& b : balls) {
            low = low.cwiseMin(b.center);
            high = high.cwiseMax(b.center);
            largest_ = std::max(largest_, b.radius);
        }
        edge_ = std::max(std::cbrt((high - low).prod() / static_cast<double>(balls.size())),
                         0x1p-20 * (high - low).maxCoeff());
        if (!(edge_ > 0)) edge_ = 1;
        for (std::uint32_t i = 0; i < balls.size(); ++i) cubes_[cube(balls[i].center)].push_back(i);
    }

    /// The balls whose surfaces may be nearer to that of ball i than `reach`, ascending, without i.
    std::vector<std::uint32_t> near(std::uint32_t i, double reach) const {
        std::vector<std::uint32_t> found;
        const Sphere& ball = balls_[i];
        const auto look_at = [&](std::uint32_t j) {
            // Margins for rounding: a ball too many costs time alone.
            const double away = (balls_[j].center - ball.center).norm() * (1 - 0x1p-40);
            if (j != i && away <= (reach + ball.radius + balls_[j].radius) * (1 + 0x1p-40))
                found.push_back(j);
        };
        const double far = (reach + ball.radius + largest_) * (1 + 0x1p-40);
        const Cube low = cube(ball.center - Vec3::Constant(far)),
                   high = cube(ball.center + Vec3::Constant(far));
        double count = 1;
        for (int k = 0; k < 3; ++k) count *= static_cast<double>(high[k] - low[k]) + 1;
        if (!(count < static_cast<double>(balls_.size()))) {
            for (std::uint32_t j = 0; j < balls_.size(); ++j) look_at(j);
            return found;
        }
        for (std::int64_t x = low[0]; x <= high[0]; ++x)
            for (std::int64_t y = low[1]; y <= high[1]; ++y)
                for (std::int64_t z = low[2]; z <= high[2]; ++z)
                    if (const auto at = cubes_.find({x, y, z}); at != cubes_.end())
                        for (const std::uint32_t j : at->second) look_at(j);
        std::ranges::sort(found);
        return found;
    }

private:
    using Cube = std::array<std::int64_t, 3>;

    Cube cube(const Vec3& p) const {
        constexpr double most = 0x1p60;
        Cube c;
        for (int k = 0; k < 3; ++k)
            c[k] = static_cast<std::int64_t>(std::clamp(std::floor(p[k] / edge_), -most, most));
        return c;
    }

    const std::vector<Sphere>& balls_;
    double edge_ = 0, largest_ = 0;
    std::map<Cube, std::vector<std::uint32_t>> cubes_;
};

// Is ball a in b? Exact; equal ones are in each other.
bool is_inside(const Sphere& a, const Sphere& b) {
    if (a.radius > b.radius) return false;
    const Exact room = Exact(b.radius) - Exact(a.radius);
    Exact square;
    for (int k = 0; k < 3; ++k) {
        const Exact d = Exact(a.center[k]) - Exact(b.center[k]);
        square = square + d * d;
    }
    return (room * room - square).sign() != Sign::Negative;
}

class DiagramCheck {
public:
    DiagramCheck(const StoredDiagram& diagram, const CheckOptions& options, unsigned threads)
        : diagram_(diagram), options_(options), threads_(threads) {
        for (const Object& o : diagram.scene.objects) balls_.push_back(std::get<Sphere>(o));
        const Box& box = diagram.scene.box;
        rounding_ = file_rounding *
                    std::max({box.max.cwiseAbs().maxCoeff(), box.min.cwiseAbs().maxCoeff(), box.diagonal()});
    }

    Certificate operator()() {
        check_cells();
        check_without_cells();
        check_pairs();
        check_volume();
        return std::move(certificate_);
    }

private:
    // What a cell shares with one ball.
    struct Shared {
        std::size_t faces = 0;
        Interval area{0.0};
        struct Vertex {
            std::vector<Site> sites;  // the cell's own ball among them
            Vec3 point;
            double error;
        };
        std::vector<Vertex> vertices;
    };

    // The cell with its scene: the balls that can reach it, and sites are places among these.
    Cell cell_in_scene(std::uint32_t object, const Cell& stored, const Grid& grid) const {
        const DiagramScene& all = diagram_.scene;
        const Measures& m = stored.measures;
        Cell cell = stored;
        Scene& scene = cell.scene;
        scene.base = all.objects[object];
        scene.box = all.box;
        scene.units = all.units;
        scene.tolerance = all.tolerance;
        const double reach = 2 * (m.max_clearance + m.max_clearance_error);
        std::vector<std::uint32_t> near =
            grid.near(object, std::isfinite(reach) ? std::max(0.0, reach) : HUGE_VAL);
        // What is in another ball owns nothing; of equal ones the first has the cell.
        std::erase_if(near, [&](std::uint32_t j) { return has_no_cell(j); });
        for (const std::uint32_t j : near) scene.objects.push_back(all.objects[j]);

        // What is not among them is no object.
        const auto place_of = [&](std::uint32_t number) {
            const auto at = std::ranges::lower_bound(near, number);
            return at != near.end() && *at == number ? static_cast<std::uint32_t>(at - near.begin())
                                                     : UINT32_MAX - 1;
        };
        const auto renumber = [&](auto& sites) {
            for (Site& site : sites)
                if (site.is_object()) site.index = place_of(site.index);
        };
        for (CellVertex& v : cell.vertices) renumber(v.sites);
        for (CellEdge& e : cell.edges) {
            renumber(e.sites);
            renumber(e.extra_sites);
        }
        for (CellFace& f : cell.faces) {
            std::array<Site, 1> site{f.site};
            renumber(site);
            f.site = site[0];
            renumber(f.extra_sites);
        }
        for (std::uint32_t& n : cell.neighbors) n = place_of(n);
        return cell;
    }

    bool has_no_cell(std::uint32_t j) const {
        return !std::ranges::binary_search(diagram_.cells, j, {}, [](const auto& c) { return c.first; });
    }

    void check_cells() {
        const Grid grid(balls_);
        in_order(
            diagram_.cells.size(), threads_,
            [&](std::size_t k) {
                const auto& [object, stored] = diagram_.cells[k];
                const Cell cell = cell_in_scene(object, stored, grid);
                Certificate certificate;
                try {
                    validate(cell.scene);
                    certificate = certify(cell, options_);
                } catch (const InputError& e) {
                    certificate.refute("scene", e.what());
                }
                return certificate;
            },
            [&](std::size_t k, Certificate of_cell) {
                const std::string name = cell_name(diagram_.cells[k].first);
                certificate_.distance = std::max(certificate_.distance, of_cell.distance);
                for (Element& e : of_cell.elements) {
                    e.where = name + "." + e.where;
                    certificate_.add(std::move(e));
                }
            });
    }

    void check_without_cells() {
        const Grid grid(balls_);
        for (std::uint32_t i = 0; i < balls_.size(); ++i) {
            if (!has_no_cell(i)) continue;
            const auto holds = [&](std::uint32_t j) {
                return is_inside(balls_[i], balls_[j]) && (j < i || !is_inside(balls_[j], balls_[i]));
            };
            if (std::ranges::any_of(grid.near(i, 0), holds))
                certificate_.prove(cell_name(i));
            else
                certificate_.refute(cell_name(i), "the ball has no cell, and lies in no other one");
        }
    }

    void check_pairs() {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::array<Shared, 2>> pairs;
        for (const auto& [object, cell] : diagram_.cells) {
            const std::uint32_t own = object;
            const auto shared = [&](std::uint32_t other) -> Shared& {
                return pairs[std::minmax(own, other)][own < other ? 0 : 1];
            };
            for (const CellFace& f : cell.faces) {
                std::vector<Site> sites{f.site};
                sites.insert(sites.end(), f.extra_sites.begin(), f.extra_sites.end());
                for (const Site site : sites) {
                    if (!site.is_object()) continue;
                    Shared& s = shared(site.index);
                    ++s.faces;
                    s.area += Interval(f.area) + Interval(-f.area_error, f.area_error);
                }
            }
            for (const CellVertex& v : cell.vertices) {
                std::vector<Site> sites(v.sites.begin(), v.sites.end());
                sites.push_back(Site::object(own));
                std::ranges::sort(sites);
                for (const Site site : v.sites)
                    if (site.is_object()) shared(site.index).vertices.push_back({sites, v.point, v.error});
            }
        }
        for (auto& [pair, sides] : pairs) {
            const std::string where = fmt::format("pairs[{}, {}]", pair.first, pair.second);
            if (const std::string fault = fault_of(sides); !fault.empty())
                certificate_.refute(where, fault);
            else
                certificate_.prove(where);
        }
    }

    std::string fault_of(std::array<Shared, 2>& sides) const {
        auto& [a, b] = sides;
        if (a.faces != b.faces)
            return fmt::format("the two cells have {} and {} faces between them", a.faces, b.faces);
        if (a.faces > 0 && (a.area.upper() < b.area.lower() || b.area.upper() < a.area.lower()))
            return fmt::format("the two cells have areas of {} and {} between them", a.area.mid(),
                               b.area.mid());
        if (a.vertices.size() != b.vertices.size())
            return fmt::format("the two cells have {} and {} vertices with both balls", a.vertices.size(),
                               b.vertices.size());
        // Few vertices have the same sites: only these are compared.
        const auto by_sites = [](const Shared::Vertex& v, const Shared::Vertex& w) {
            return v.sites < w.sites;
        };
        std::ranges::stable_sort(a.vertices, by_sites);
        std::ranges::stable_sort(b.vertices, by_sites);
        std::vector<char> is_taken(b.vertices.size(), 0);
        for (const Shared::Vertex& v : a.vertices) {
            const auto [first, last] = std::equal_range(b.vertices.begin(), b.vertices.end(), v, by_sites);
            const auto twin = std::find_if(first, last, [&](const Shared::Vertex& w) {
                return !is_taken[&w - b.vertices.data()] &&
                       (v.point - w.point).norm() <= v.error + w.error + rounding_;
            });
            if (twin == last) {
                std::string sites;
                for (const Site s : v.sites) sites += (sites.empty() ? "" : ", ") + to_string(s);
                return fmt::format("only one of the two cells has the vertex of {} at ({}, {}, {})", sites,
                                   v.point.x(), v.point.y(), v.point.z());
            }
            is_taken[twin - b.vertices.begin()] = 1;
        }
        return {};
    }

    void check_volume() {
        Interval sum(0.0), box(1.0);
        for (const auto& [object, cell] : diagram_.cells) {
            const Measures& m = cell.measures;
            sum += Interval(m.volume) + Interval(-m.volume_error, m.volume_error);
        }
        for (int k = 0; k < 3; ++k)
            box *= Interval(diagram_.scene.box.max[k]) - Interval(diagram_.scene.box.min[k]);
        if (sum.upper() < box.lower() || box.upper() < sum.lower())
            certificate_.refute("volume",
                                fmt::format("the cells' volumes add up to {} within {}, the box has {}",
                                            sum.mid(), sum.radius(), box.mid()),
                                std::max(box.lower() - sum.upper(), sum.lower() - box.upper()));
        else
            certificate_.prove("volume", (sum - box).magnitude());
    }

    const StoredDiagram& diagram_;
    const CheckOptions& options_;
    const unsigned threads_;
    std::vector<Sphere> balls_;
    double rounding_ = 0;  // of points, in the scene's unit
    Certificate certificate_;
};

}  // namespace

Certificate certify(const StoredDiagram& diagram, const CheckOptions& options, unsigned threads) {
    return DiagramCheck(diagram, options, threads)();
}

}  // namespace vcell
