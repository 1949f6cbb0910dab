/// The processes of a run, and what they do together.
///
/// All functions are called by all ranks, in the same order. What only one rank finds wrong ends all of them:
/// work that may throw and talks to nobody goes through together().
#pragma once

#include <mpi.h>

#include <cstdint>
#include <exception>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "../apps/command.hpp"
#include "letter.hpp"

namespace vcell::mpi {

/// Some rank failed; every rank throws it, with what that one says.
struct SharedFailure : std::exception {
    explicit SharedFailure(Failure f) : failure(std::move(f)) {}
    const char* what() const noexcept override { return failure.text.c_str(); }
    Failure failure;
};

class Ranks {
public:
    /// Initialises MPI, for calls by one thread at a time.
    Ranks(int& argc, char**& argv);
    ~Ranks();
    Ranks(const Ranks&) = delete;
    Ranks& operator=(const Ranks&) = delete;

    int rank() const { return rank_; }
    int size() const { return size_; }
    bool is_first() const { return rank_ == 0; }
    MPI_Comm all() const { return MPI_COMM_WORLD; }
    /// Bytes that this rank has sent to others.
    std::uint64_t bytes_sent() const { return bytes_sent_; }

    /// Sends to[r] to rank r; returns what each rank has sent to this one.
    std::vector<Letter> exchange(std::vector<Letter> to);
    /// Everybody's letters, by rank.
    std::vector<Letter> share(const Letter& mine);
    /// What rank `from` has.
    Letter broadcast(Letter letter, int from);

    std::uint64_t sum(std::uint64_t x) const;
    std::uint64_t most(std::uint64_t x) const;
    double sum(double x) const;
    /// The sum of lower ranks' numbers.
    std::uint64_t before(std::uint64_t x) const;

    /// f() on every rank. Where it throws on some, throws SharedFailure on all, as the lowest of these. Pre:
    /// f talks to no other rank.
    template <class F>
    auto together(F&& f) {
        using Result = decltype(f());
        std::optional<Failure> failure;
        if constexpr (std::is_void_v<Result>) {
            try {
                f();
            } catch (...) {
                failure = failure_of_exception();
            }
            agree(failure);
        } else {
            std::optional<Result> result;
            try {
                result.emplace(f());
            } catch (...) {
                failure = failure_of_exception();
            }
            agree(failure);
            return *std::move(result);
        }
    }

private:
    void agree(const std::optional<Failure>& failure);

    int rank_ = 0, size_ = 1;
    std::uint64_t bytes_sent_ = 0;
};

}  // namespace vcell::mpi
