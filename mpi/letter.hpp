/// Bytes from one process to another: what is put in comes out in the same order.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "../envelope/voronoi_diagram.hpp"

namespace vcell::mpi {

class Letter {
public:
    template <class T>
    requires std::is_trivially_copyable_v<T>
    void put(const T& value) {
        const auto* first = reinterpret_cast<const char*>(&value);
        bytes_.insert(bytes_.end(), first, first + sizeof(T));
    }
    void put(const Vec3& v);
    void put(const Sphere& ball);
    void put(const Object& object);
    void put(std::string_view text);
    void put(const std::string& text) { put(std::string_view(text)); }
    void put(const DiagramCell& cell);
    void put(const Letter& other) { bytes_.insert(bytes_.end(), other.bytes_.begin(), other.bytes_.end()); }
    template <class T>
    void put(const std::vector<T>& values) {
        put(static_cast<std::uint64_t>(values.size()));
        for (const T& value : values) put(value);
    }

    bool empty() const { return bytes_.empty(); }
    std::vector<char>& bytes() { return bytes_; }
    const std::vector<char>& bytes() const { return bytes_; }

private:
    std::vector<char> bytes_;
};

/// Pre of all that takes something out: it was put in.
class LetterReader {
public:
    explicit LetterReader(const Letter& letter) : bytes_(letter.bytes()) {}

    bool at_end() const { return at_ == bytes_.size(); }
    template <class T>
    T get() {
        if constexpr (std::is_same_v<T, Vec3>) {
            const double x = get<double>(), y = get<double>(), z = get<double>();
            return {x, y, z};
        } else if constexpr (std::is_same_v<T, Sphere>) {
            const Vec3 center = get<Vec3>();
            return {center, get<double>()};
        } else if constexpr (std::is_same_v<T, std::string>) {
            return text();
        } else if constexpr (std::is_same_v<T, Object>) {
            return object();
        } else if constexpr (std::is_same_v<T, DiagramCell>) {
            return cell();
        } else {
            static_assert(std::is_trivially_copyable_v<T>);
            T value;
            std::memcpy(&value, take(sizeof(T)), sizeof(T));
            return value;
        }
    }
    template <class T>
    std::vector<T> list() {
        std::vector<T> values(get<std::uint64_t>());
        for (T& value : values) value = get<T>();
        return values;
    }

private:
    const char* take(std::size_t count);
    std::string text();
    Object object();
    DiagramCell cell();

    const std::vector<char>& bytes_;
    std::size_t at_ = 0;
};

}  // namespace vcell::mpi
