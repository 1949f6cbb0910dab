/// Sequences that are short nearly always.
#pragma once

#include "platform.hpp"

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace vcell {

/// As std::vector, but the first N elements lie inside: a cell of thousands of short curves is built without
/// an allocation for each. Moving one that holds N elements or fewer copies them. Elements are copied where
/// more room is needed, and never destroyed.
template <class T, std::size_t N>
class SmallVector {
    static_assert(std::is_trivially_destructible_v<T> && alignof(T) <= __STDCPP_DEFAULT_NEW_ALIGNMENT__);

public:
    using value_type = T;
    using size_type = std::size_t;
    using difference_type = std::ptrdiff_t;
    using reference = T&;
    using const_reference = const T&;
    using iterator = T*;
    using const_iterator = const T*;

    SmallVector() {}  // not defaulted: value-initialization would fill what lies inside with zeros
    SmallVector(std::initializer_list<T> items) : SmallVector(items.begin(), items.end()) {}
    template <std::forward_iterator It>
    SmallVector(It first, It last) {
        assign(first, last);
    }
    SmallVector(const SmallVector& o) : SmallVector(o.begin(), o.end()) {}
    SmallVector(SmallVector&& o) noexcept { take(o); }
    SmallVector& operator=(const SmallVector& o) {
        if (this != &o) assign(o.begin(), o.end());
        return *this;
    }
    SmallVector& operator=(SmallVector&& o) noexcept {
        if (this == &o) return *this;
        release();
        take(o);
        return *this;
    }
    ~SmallVector() { release(); }

    T* data() { return data_; }
    const T* data() const { return data_; }
    T* begin() { return data_; }
    T* end() { return data_ + size_; }
    const T* begin() const { return data_; }
    const T* end() const { return data_ + size_; }
    std::size_t size() const { return size_; }
    std::size_t capacity() const { return capacity_; }
    bool empty() const { return size_ == 0; }
    T& operator[](std::size_t i) { return data_[i]; }
    const T& operator[](std::size_t i) const { return data_[i]; }
    T& front() { return data_[0]; }
    const T& front() const { return data_[0]; }
    T& back() { return data_[size_ - 1]; }
    const T& back() const { return data_[size_ - 1]; }

    void reserve(std::size_t capacity) {
        if (capacity > capacity_) grow(capacity);
    }
    void clear() { size_ = 0; }
    void push_back(const T& item) {
        if (size_ == capacity_) [[unlikely]]
            return push_back_grown(item);
        std::construct_at(data_ + size_, item);
        ++size_;
    }
    template <class... Args>
    T& emplace_back(Args&&... args) {
        push_back(T(std::forward<Args>(args)...));
        return back();
    }
    void pop_back() { --size_; }
    void resize(std::size_t size) {
        reserve(size);
        if (size > size_) std::uninitialized_value_construct(data_ + size_, data_ + size);
        size_ = size;
    }
    template <std::forward_iterator It>
    void assign(It first, It last) {
        size_ = 0;
        append(first, last);
    }
    void assign(std::size_t count, const T& item) {
        size_ = 0;
        append(count, item);
    }
    /// Pre: the items are not of this sequence.
    template <std::forward_iterator It>
    T* insert(const T* at, It first, It last) {
        const std::ptrdiff_t before = at - data_;
        append(first, last);
        return rotated(before, std::distance(first, last));
    }
    T* insert(const T* at, std::size_t count, const T& item) {
        const std::ptrdiff_t before = at - data_;
        append(count, item);
        return rotated(before, static_cast<std::ptrdiff_t>(count));
    }
    T* insert(const T* at, const T& item) { return insert(at, 1, T(item)); }
    T* erase(const T* at) { return erase(at, at + 1); }
    T* erase(const T* first, const T* last) {
        T* const at = data_ + (first - data_);
        size_ = std::copy(last, static_cast<const T*>(end()), at) - data_;
        return at;
    }

    /// As std::erase_if().
    template <class Predicate>
    friend std::size_t erase_if(SmallVector& all, const Predicate& goes) {
        const std::size_t before = all.size();
        all.erase(std::remove_if(all.begin(), all.end(), goes), all.end());
        return before - all.size();
    }

    friend bool operator==(const SmallVector& a, const SmallVector& b) {
        return std::equal(a.begin(), a.end(), b.begin(), b.end());
    }

private:
    template <std::forward_iterator It>
    void append(It first, It last) {
        const auto count = static_cast<std::size_t>(std::distance(first, last));
        make_room(count);
        std::uninitialized_copy(first, last, data_ + size_);
        size_ += count;
    }
    void append(std::size_t count, const T& item) {
        make_room(count);
        std::uninitialized_fill_n(data_ + size_, count, item);
        size_ += count;
    }
    // The last `count` elements moved to where `before` others precede them.
    T* rotated(std::ptrdiff_t before, std::ptrdiff_t count) {
        std::rotate(begin() + before, end() - count, end());
        return begin() + before;
    }
    void make_room(std::size_t count) {
        if (size_ + count > capacity_) grow(std::max(size_ + count, 2 * capacity_));
    }
    void push_back_grown(T item) {  // a copy: of an element, perhaps
        grow(2 * capacity_);
        std::construct_at(data_ + size_, item);
        ++size_;
    }
    void grow(std::size_t capacity) {
        T* const room = std::allocator<T>().allocate(capacity);
        std::uninitialized_copy(data_, data_ + size_, room);
        release();
        data_ = room;
        capacity_ = capacity;
    }
    void release() {
        if (data_ != inside()) std::allocator<T>().deallocate(data_, capacity_);
    }
    void take(SmallVector& o) {
        size_ = o.size_;
        if (o.data_ == o.inside()) {
            data_ = inside();
            capacity_ = N;
            std::uninitialized_copy(o.begin(), o.end(), data_);
        } else {
            data_ = o.data_;
            capacity_ = o.capacity_;
            o.data_ = o.inside();
            o.capacity_ = N;
        }
        o.size_ = 0;
    }
    T* inside() { return reinterpret_cast<T*>(inside_); }

    T* data_ = inside();
    std::size_t size_ = 0, capacity_ = N;
    alignas(T) std::byte inside_[N * sizeof(T)];
};

/// Appends an element and returns it, its members as their own initializers leave them; those without one are
/// indeterminate. emplace_back() would fill an aggregate with zeros first, the room inside its short
/// sequences too.
template <class T>
T& append_new(std::vector<T>& all) {
    struct Maker {
        operator T() const {
            T element;
            return element;
        }
    };
    return all.emplace_back(Maker());
}

}  // namespace vcell
