/// What a check has established: one element for each statement about a cell, proved, refuted or open.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

namespace vcell {

enum class Verdict : std::uint8_t { proved, refuted, open };
std::string_view to_string(Verdict verdict);

/// One statement about one place of the cell.
struct Element {
    std::string
        where;  ///< as the cell file names it: "vertices[3]", "faces[2].patches[0]", "measures.volume"
    Verdict verdict = Verdict::open;
    /// Refuted: what is wrong. Open: why nothing could be proved. Proved: empty, or what the proof took for
    /// granted or has found worth saying (a tie, with the width to which it was verified).
    std::string what;
    /// Length, or for a measure its own unit. Proved: how far from the true one what is written lies at most.
    /// Refuted: by how much it is wrong at least; 0 where that is no number. Open: the bound that was
    /// reached, infinite if none was.
    double amount = 0;
};

struct Certificate {
    std::vector<Element> elements;
    /// The boundary as written lies everywhere within this length of the true one, if the certificate holds.
    double distance = 0;

    void prove(std::string where, double amount = 0, std::string what = {});
    void refute(std::string where, std::string what, double amount = 0);
    void leave_open(std::string where, std::string what, double amount);
    void add(Element element);

    std::size_t count(Verdict verdict) const { return counts_[static_cast<std::size_t>(verdict)]; }
    /// Nothing is refuted and nothing is open.
    bool holds() const { return count(Verdict::refuted) == 0 && count(Verdict::open) == 0; }

private:
    std::array<std::size_t, 3> counts_{};
};

/// {"vcell": 1, "holds": ..., "distance": ..., "proved": n, "refuted": n, "open": n, "elements": [...]}.
void write_certificate(std::ostream& out, const Certificate& certificate);

}  // namespace vcell
