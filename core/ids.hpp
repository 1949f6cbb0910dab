/// Typed indices: an Id knows what it indexes, so a vertex never meets a face by accident.
#pragma once

#include "platform.hpp"

#include <compare>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

namespace vcell {

/// An index into an IdVector of the same tag. UINT32_MAX means "none".
template <class Tag>
struct Id {
    std::uint32_t value = UINT32_MAX;

    constexpr bool valid() const { return value != UINT32_MAX; }
    friend constexpr auto operator<=>(Id, Id) = default;
};

/// "v12", "h7": the tag's letter and the index, for messages.
template <class Tag>
std::string to_string(Id<Tag> id) {
    return id.valid() ? Tag::letter + std::to_string(id.value) : std::string("none");
}

/// A vector indexed by one kind of Id only.
template <class I, class T>
class IdVector {
public:
    IdVector() = default;
    explicit IdVector(std::size_t n, const T& value = T()) : data_(n, value) {}
    IdVector(std::initializer_list<T> values) : data_(values) {}

    decltype(auto) operator[](I id) { return data_[id.value]; }
    decltype(auto) operator[](I id) const { return data_[id.value]; }
    I push_back(const T& value) {
        data_.push_back(value);
        return I{static_cast<std::uint32_t>(data_.size() - 1)};
    }
    std::size_t size() const { return data_.size(); }
    bool empty() const { return data_.empty(); }
    void clear() { data_.clear(); }
    void resize(std::size_t n, const T& value = T()) { data_.resize(n, value); }
    void reserve(std::size_t n) { data_.reserve(n); }
    T& back() { return data_.back(); }
    auto begin() { return data_.begin(); }
    auto end() { return data_.end(); }
    auto begin() const { return data_.begin(); }
    auto end() const { return data_.end(); }
    T* data() { return data_.data(); }
    const T* data() const { return data_.data(); }

    /// All ids of the vector in order, for range-for.
    struct IdRange {
        struct Iterator {
            std::uint32_t value;
            I operator*() const { return I{value}; }
            Iterator& operator++() {
                ++value;
                return *this;
            }
            friend bool operator==(Iterator, Iterator) = default;
        };
        std::uint32_t count;
        Iterator begin() const { return {0}; }
        Iterator end() const { return {count}; }
    };
    IdRange ids() const { return {static_cast<std::uint32_t>(data_.size())}; }

private:
    std::vector<T> data_;
};

}  // namespace vcell
