#include "ball_file.hpp"

#include <algorithm>
#include <cctype>

#include "../../core/errors.hpp"
#include "ball_lines.hpp"

namespace vcell {

namespace {

enum class Format { None, Pdb, Mmcif, Xyz, LammpsDump };

// Records that a PDB file may begin with.
constexpr std::string_view pdb_beginnings[] = {
    "HEADER", "OBSLTE", "TITLE ", "SPLIT ", "CAVEAT", "COMPND", "SOURCE", "KEYWDS",
    "EXPDTA", "AUTHOR", "REMARK", "CRYST1", "MODEL ", "ATOM  ", "HETATM",
};

Format format_of(std::string_view text) {
    Lines lines(text);
    bool is_first = true;
    while (!lines.at_end()) {
        std::string_view line = lines.next();
        if (is_first) {
            if (std::ranges::any_of(pdb_beginnings, [&](auto record) { return line.starts_with(record); }))
                return Format::Pdb;
            if (line.starts_with("ITEM:")) return Format::LammpsDump;
        }
        const std::string_view word = next_word(line);
        if (word.empty()) {
            is_first = false;
            continue;
        }
        const bool is_one_number =
            word.find_first_not_of("0123456789") == word.npos && next_word(line).empty();
        if (is_first && is_one_number) return Format::Xyz;
        is_first = false;
        if (word.starts_with('#')) continue;
        std::string start(word.substr(0, 5));
        std::ranges::transform(start, start.begin(), [](unsigned char c) { return std::tolower(c); });
        return start == "data_" ? Format::Mmcif : Format::None;
    }
    return Format::None;
}

void refuse(bool is_given, const char* option, const char* is_for) {
    if (is_given)
        throw InputError(InputError::Kind::Unsupported, InputError::no_object, option,
                         fmt::format("is for {} files", is_for));
}

}  // namespace

std::optional<BallFile> parse_ball_file(std::string_view text, const BallFileOptions& options) {
    if (text.starts_with("\x1F\x8B"))
        throw InputError(InputError::Kind::Syntax, InputError::no_object, "",
                         "this file is packed by gzip; gzip -dc FILE | vcell ... - reads it");
    text = without_byte_order_mark(text);
    const Format format = format_of(text);
    if (format == Format::None) {
        refuse(options.frame.has_value(), "--frame", "PDB, mmCIF, XYZ and LAMMPS dump");
        refuse(!options.radii.empty(), "--radius", "PDB, mmCIF, XYZ and LAMMPS dump");
    }
    if (format != Format::Pdb && format != Format::Mmcif) {
        const char* molecules = "PDB and mmCIF";
        refuse(options.has_hydrogens, "--hydrogens", molecules);
        refuse(options.leaves_water, "--no-water", molecules);
        refuse(options.leaves_hetero, "--no-hetero", molecules);
        refuse(options.group.has_value(), "--group", molecules);
    }
    switch (format) {
        case Format::None: break;
        case Format::Pdb: return parse_pdb(text, options);
        case Format::Mmcif: return parse_mmcif(text, options);
        case Format::Xyz: return parse_xyz(text, options);
        case Format::LammpsDump: return parse_lammps_dump(text, options);
    }
    return std::nullopt;
}

}  // namespace vcell
