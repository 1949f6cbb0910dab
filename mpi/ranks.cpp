#include "ranks.hpp"

#include <algorithm>
#include <limits>

#include "../core/errors.hpp"

namespace vcell::mpi {

namespace {

// MPI counts in ints; blocks of bytes are counted, so that letters may have a hundred gigabytes.
constexpr std::size_t block = 64;

class BlockType {
public:
    BlockType() {
        MPI_Type_contiguous(block, MPI_BYTE, &type_);
        MPI_Type_commit(&type_);
    }
    ~BlockType() { MPI_Type_free(&type_); }
    BlockType(const BlockType&) = delete;
    BlockType& operator=(const BlockType&) = delete;
    MPI_Datatype get() const { return type_; }

private:
    MPI_Datatype type_{};
};

// The letters one after the other, each from a block's beginning.
struct Bundle {
    std::vector<int> counts, begins;
    std::vector<char> bytes;

    explicit Bundle(const std::vector<std::uint64_t>& sizes) {
        std::size_t blocks = 0;
        for (const std::uint64_t size : sizes) {
            const std::size_t count = (size + block - 1) / block;
            begins.push_back(static_cast<int>(blocks));
            counts.push_back(static_cast<int>(count));
            blocks += count;
        }
        if (blocks > static_cast<std::size_t>(std::numeric_limits<int>::max()))
            throw InternalError("letters between processes are too long for MPI");
        bytes.resize(block * blocks);
    }
    std::vector<Letter> letters(const std::vector<std::uint64_t>& sizes) const {
        std::vector<Letter> letters(sizes.size());
        for (std::size_t i = 0; i < sizes.size(); ++i) {
            const char* first = bytes.data() + block * static_cast<std::size_t>(begins[i]);
            letters[i].bytes().assign(first, first + sizes[i]);
        }
        return letters;
    }
};

}  // namespace

Ranks::Ranks(int& argc, char**& argv) {
    int provided = 0;
    MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
    MPI_Comm_rank(all(), &rank_);
    MPI_Comm_size(all(), &size_);
}

Ranks::~Ranks() { MPI_Finalize(); }

std::vector<Letter> Ranks::exchange(std::vector<Letter> to) {
    std::vector<std::uint64_t> sizes, sizes_from(to.size());
    for (const Letter& letter : to) sizes.push_back(letter.bytes().size());
    MPI_Alltoall(sizes.data(), 1, MPI_UINT64_T, sizes_from.data(), 1, MPI_UINT64_T, all());
    Bundle out(sizes), in(sizes_from);
    for (int r = 0; r < size_; ++r) {
        Letter& letter = to[r];
        std::ranges::copy(letter.bytes(),
                          out.bytes.begin() + static_cast<std::ptrdiff_t>(block) * out.begins[r]);
        if (r != rank_) bytes_sent_ += letter.bytes().size();
        letter = {};
    }
    const BlockType type;
    MPI_Alltoallv(out.bytes.data(), out.counts.data(), out.begins.data(), type.get(), in.bytes.data(),
                  in.counts.data(), in.begins.data(), type.get(), all());
    return in.letters(sizes_from);
}

std::vector<Letter> Ranks::share(const Letter& mine) {
    const std::uint64_t size = mine.bytes().size();
    std::vector<std::uint64_t> sizes(size_);
    MPI_Allgather(&size, 1, MPI_UINT64_T, sizes.data(), 1, MPI_UINT64_T, all());
    Bundle out({size}), in(sizes);
    std::ranges::copy(mine.bytes(), out.bytes.begin());
    bytes_sent_ += size * static_cast<std::uint64_t>(size_ - 1);
    const BlockType type;
    MPI_Allgatherv(out.bytes.data(), out.counts[0], type.get(), in.bytes.data(), in.counts.data(),
                   in.begins.data(), type.get(), all());
    return in.letters(sizes);
}

Letter Ranks::broadcast(Letter letter, int from) {
    std::uint64_t size = letter.bytes().size();
    MPI_Bcast(&size, 1, MPI_UINT64_T, from, all());
    Bundle bundle({size});
    if (rank_ == from) std::ranges::copy(letter.bytes(), bundle.bytes.begin());
    const BlockType type;
    MPI_Bcast(bundle.bytes.data(), bundle.counts[0], type.get(), from, all());
    if (rank_ == from) bytes_sent_ += size * static_cast<std::uint64_t>(size_ - 1);
    return std::move(bundle.letters({size})[0]);
}

std::uint64_t Ranks::sum(std::uint64_t x) const {
    std::uint64_t total = 0;
    MPI_Allreduce(&x, &total, 1, MPI_UINT64_T, MPI_SUM, all());
    return total;
}

std::uint64_t Ranks::most(std::uint64_t x) const {
    std::uint64_t result = 0;
    MPI_Allreduce(&x, &result, 1, MPI_UINT64_T, MPI_MAX, all());
    return result;
}

double Ranks::sum(double x) const {
    double total = 0;
    MPI_Allreduce(&x, &total, 1, MPI_DOUBLE, MPI_SUM, all());
    return total;
}

std::uint64_t Ranks::before(std::uint64_t x) const {
    std::uint64_t total = 0;
    MPI_Exscan(&x, &total, 1, MPI_UINT64_T, MPI_SUM, all());
    return rank_ == 0 ? 0 : total;
}

void Ranks::agree(const std::optional<Failure>& failure) {
    const int mine = failure ? rank_ : size_;
    int first = size_;
    MPI_Allreduce(&mine, &first, 1, MPI_INT, MPI_MIN, all());
    if (first == size_) return;
    Letter letter;
    if (rank_ == first) {
        letter.put(failure->status);
        letter.put(failure->text);
    }
    const Letter said = broadcast(std::move(letter), first);
    LetterReader in(said);
    const auto status = in.get<Status>();
    throw SharedFailure({status, in.get<std::string>()});
}

}  // namespace vcell::mpi
