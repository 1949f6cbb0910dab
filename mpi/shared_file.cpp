#include "shared_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <ostream>

namespace vcell::mpi {

namespace {

// MPI counts in ints.
constexpr std::size_t piece = std::size_t{1} << 30;

}  // namespace

SharedFile::SharedFile(Ranks& ranks, const std::string& target) : ranks_(ranks), target_(target) {
    Letter name;
    ranks_.together([&] {
        if (!ranks_.is_first()) return;
        file_ = std::make_unique<OutputFile>(target_, OutputFile::Unfinished::Hidden);
        name.put(file_->hidden());
    });
    const Letter said = ranks_.broadcast(std::move(name), 0);
    hidden_ = LetterReader(said).get<std::string>();
}

void SharedFile::check(int error) {
    ranks_.together([&] {
        if (error == MPI_SUCCESS) return;
        std::array<char, MPI_MAX_ERROR_STRING> text{};
        int length = 0;
        MPI_Error_string(error, text.data(), &length);
        throw WriteError(fmt::format("cannot write {}: {}", target_, text.data()));
    });
}

void SharedFile::write_by_first(const std::string& part) {
    for (int rank = 0; rank < ranks_.size(); ++rank) {
        std::vector<Letter> to(ranks_.size());
        if (rank == ranks_.rank()) to[0].bytes().assign(part.begin(), part.end());
        const std::vector<Letter> got = ranks_.exchange(std::move(to));
        if (!ranks_.is_first()) continue;
        const std::vector<char>& bytes = got[rank].bytes();
        file_->stream().write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    }
}

void SharedFile::write(const std::string& part) {
    if (hidden_.empty()) return write_by_first(part);
    MPI_File file{};
    check(MPI_File_open(ranks_.all(), hidden_.c_str(), MPI_MODE_WRONLY, MPI_INFO_NULL, &file));
    const std::uint64_t begin = ranks_.before(part.size()),
                        pieces = ranks_.most((part.size() + piece - 1) / piece);
    int error = MPI_SUCCESS;
    for (std::uint64_t k = 0; k < pieces; ++k) {
        const std::size_t at = std::min(part.size(), k * piece), size = std::min(piece, part.size() - at);
        const int result = MPI_File_write_at_all(file, static_cast<MPI_Offset>(begin + at), part.data() + at,
                                                 static_cast<int>(size), MPI_BYTE, MPI_STATUS_IGNORE);
        if (error == MPI_SUCCESS) error = result;
    }
    const int closed = MPI_File_close(&file);
    check(error != MPI_SUCCESS ? error : closed);
}

void SharedFile::close() {
    ranks_.together([&] {
        if (file_) file_->close();
    });
}

void SharedFile::commit() {
    ranks_.together([&] {
        if (file_) file_->commit();
    });
}

}  // namespace vcell::mpi
