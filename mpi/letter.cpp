#include "letter.hpp"

#include "../core/errors.hpp"

namespace vcell::mpi {

void Letter::put(const Vec3& v) {
    for (const double x : v) put(x);
}

void Letter::put(const Sphere& ball) {
    put(ball.center);
    put(ball.radius);
}

void Letter::put(const Object& object) {
    put(static_cast<std::uint8_t>(object.index()));
    std::visit(
        [&](const auto& o) {
            if constexpr (requires { o.center; }) {
                put(o.center);
                put(o.radius);
            } else if constexpr (requires { o.normal; }) {
                put(o.point);
                put(o.normal);
            } else if constexpr (requires { o.apex; }) {
                put(o.apex);
                put(o.axis);
                put(o.radius);
                put(o.slant);
            } else {
                put(o.point);
                put(o.axis);
                put(o.radius);
            }
        },
        object);
}

void Letter::put(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size()));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
}

void Letter::put(const DiagramCell& c) {
    put(c.state);
    put(c.reason);
    for (const double x : {c.volume, c.volume_error, c.area, c.area_error, c.exposed_area, c.exposed_error,
                           c.min_clearance, c.max_clearance, c.reach})
        put(x);
    put(c.touches_box);
    put(c.is_estimated);
    put(c.candidates);
    put(c.assumed);
    put(c.contacts);
}

const char* LetterReader::take(std::size_t count) {
    if (bytes_.size() - at_ < count) throw InternalError("a letter between processes ends early");
    const char* first = bytes_.data() + at_;
    at_ += count;
    return first;
}

std::string LetterReader::text() {
    const auto size = get<std::uint32_t>();
    return {take(size), size};
}

Object LetterReader::object() {
    const auto read = [&](auto o) -> Object {
        if constexpr (requires { o.center; }) {
            o.center = get<Vec3>();
            o.radius = get<double>();
        } else if constexpr (requires { o.normal; }) {
            o.point = get<Vec3>();
            o.normal = get<Vec3>();
        } else if constexpr (requires { o.apex; }) {
            o.apex = get<Vec3>();
            o.axis = get<Vec3>();
            o.radius = get<double>();
            o.slant = get<double>();
        } else {
            o.point = get<Vec3>();
            o.axis = get<Vec3>();
            o.radius = get<double>();
        }
        return o;
    };
    static_assert(std::variant_size_v<Object> == 6);
    switch (get<std::uint8_t>()) {
        case 0: return read(std::variant_alternative_t<0, Object>());
        case 1: return read(std::variant_alternative_t<1, Object>());
        case 2: return read(std::variant_alternative_t<2, Object>());
        case 3: return read(std::variant_alternative_t<3, Object>());
        case 4: return read(std::variant_alternative_t<4, Object>());
        default: return read(std::variant_alternative_t<5, Object>());
    }
}

DiagramCell LetterReader::cell() {
    DiagramCell c;
    c.state = get<DiagramCell::State>();
    c.reason = text();
    for (double* x : {&c.volume, &c.volume_error, &c.area, &c.area_error, &c.exposed_area, &c.exposed_error,
                      &c.min_clearance, &c.max_clearance, &c.reach})
        *x = get<double>();
    c.touches_box = get<bool>();
    c.is_estimated = get<bool>();
    c.candidates = get<std::uint32_t>();
    c.assumed = get<std::uint64_t>();
    c.contacts = list<CellContact>();
    return c;
}

}  // namespace vcell::mpi
