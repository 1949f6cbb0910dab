// Atoms of PDB and mmCIF files.
//
// These readers are our own: gemmi's, which Debian has, take a coordinate that is no number for 0 and
// never tell a line, and what is not understood here must be named.
#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "ball_file.hpp"
#include "ball_lines.hpp"

namespace vcell {

namespace {

// ---- Atoms ------------------------------------------------------------------------------------------

struct Atom {
    std::string_view name, location, residue, chain, number, insertion, element;
    bool is_hetero = false;
    Vec3 center = Vec3::Zero();
    std::size_t line = 0;
};

std::string upper(std::string_view text) {
    std::string result(text);
    std::ranges::transform(result, result.begin(),
                           [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return result;
}

bool is_water(std::string_view residue) {
    static constexpr std::string_view names[] = {"HOH", "DOD",  "WAT",  "H2O",  "SOL", "TIP",
                                                 "TP3", "TIP3", "TIP4", "TIP5", "SPC"};
    const std::string name = upper(residue);
    return std::ranges::find(names, name) != std::end(names);
}

// Takes atoms as they come and keeps those that are wanted.
class Molecule {
public:
    explicit Molecule(const BallFileOptions& options) : options_(options) {}

    void add(const Atom& atom) {
        if (options_.leaves_hetero && atom.is_hetero) return;
        if (options_.leaves_water && is_water(atom.residue)) return;
        const std::string element = upper(atom.element);
        if (!options_.has_hydrogens && (element == "H" || element == "D")) return;
        // Whoever is at one place is not at the others: a residue's first one counts.
        if (!atom.location.empty()) {
            const std::string residue = key({atom.chain, atom.number, atom.insertion});
            const auto [first, is_new] = locations_.try_emplace(residue, atom.location);
            if (first->second != atom.location) return;
        }
        file_.balls.push_back({atom.center, radius_of(atom.element, options_, atom.line)});
        const std::string residue =
            fmt::format("{}:{}{}{}", atom.chain, atom.residue, atom.number, atom.insertion);
        file_.names.push_back(fmt::format("{}:{}", residue, atom.name));
        const bool by_chain = options_.group == BallFileOptions::Group::Chain;
        file_.groups.push_back(by_chain ? std::string(atom.chain) : residue);
    }

    BallFile take() {
        if (file_.balls.empty())
            throw InputError(InputError::Kind::Syntax, InputError::no_object, "",
                             "there is no atom among what is read");
        file_.units = "angstrom";
        return std::move(file_);
    }

private:
    static std::string key(std::initializer_list<std::string_view> parts) {
        std::string result;
        for (const std::string_view part : parts) result.append(part).push_back('\0');
        return result;
    }

    const BallFileOptions& options_;
    BallFile file_;
    std::map<std::string, std::string_view> locations_;  // the first one of each residue
};

// ---- PDB --------------------------------------------------------------------------------------------

// Records without coordinates of atoms [PDB33], and some that programs add.
const std::set<std::string_view> other_records{
    "HEADER", "OBSLTE", "TITLE",  "SPLIT",  "CAVEAT", "COMPND", "SOURCE", "KEYWDS", "EXPDTA", "NUMMDL",
    "MDLTYP", "AUTHOR", "REVDAT", "SPRSDE", "JRNL",   "REMARK", "DBREF",  "DBREF1", "DBREF2", "SEQADV",
    "SEQRES", "MODRES", "HET",    "FORMUL", "HETNAM", "HETSYN", "HELIX",  "SHEET",  "TURN",   "SSBOND",
    "LINK",   "LINKR",  "HYDBND", "SLTBRG", "CISPEP", "SITE",   "CRYST1", "ORIGX1", "ORIGX2", "ORIGX3",
    "SCALE1", "SCALE2", "SCALE3", "MTRIX1", "MTRIX2", "MTRIX3", "TVECT",  "ANISOU", "SIGATM", "SIGUIJ",
    "TER",    "CONECT", "MASTER", "USER",   "FTNOTE", "PSDO",
};

// Columns first to last, counted from 1, without blanks around.
std::string_view columns(std::string_view line, std::size_t first, std::size_t last) {
    if (line.size() < first) return {};
    std::string_view field = line.substr(first - 1, last - first + 1);
    const std::size_t begin = field.find_first_not_of(' ');
    if (begin == field.npos) return {};
    return field.substr(begin, field.find_last_not_of(' ') - begin + 1);
}

// Where columns 77 and 78 leave it open, the element is in columns 13 and 14 of the atom's name [PDB33]:
// right- justified, so one letter stands in 14; only names of four letters of hydrogens begin in 13.
std::string_view element_of(std::string_view line) {
    if (const std::string_view given = columns(line, 77, 78); !given.empty()) return given;
    const std::string_view field = line.substr(12, 4);
    const auto is_letter = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); };
    if (!is_letter(field[0])) return field.substr(1, 1);
    const bool is_hydrogen = (field[0] == 'H' || field[0] == 'D') && field.find(' ') == field.npos;
    return field.substr(0, is_hydrogen || !is_letter(field[1]) ? 1 : 2);
}

Atom pdb_atom(std::string_view line, std::size_t number) {
    if (line.size() < 54)
        fail_line(number, fmt::format("a PDB atom's coordinates end in column 54, the line in column {}",
                                      line.size()));
    Atom atom;
    atom.line = number;
    atom.is_hetero = line.starts_with("HETATM");
    atom.name = columns(line, 13, 16);
    atom.location = columns(line, 17, 17);
    atom.residue = columns(line, 18, 20);
    if (line[20] != ' ') atom.residue = columns(line, 18, 21);  // names of four letters, of some programs
    atom.chain = columns(line, 22, 22);
    atom.number = columns(line, 23, 26);
    atom.insertion = columns(line, 27, 27);
    for (int k = 0; k < 3; ++k) {
        const std::string_view field = columns(line, 31 + 8 * k, 38 + 8 * k);
        if (field.empty())
            fail_line(number,
                      fmt::format("{} is missing in columns {} to {}", "xyz"[k], 31 + 8 * k, 38 + 8 * k));
        atom.center[k] = parse_number(field, number);
    }
    atom.element = element_of(line);
    return atom;
}

// ---- mmCIF ------------------------------------------------------------------------------------------

// The words of a CIF file [CIF11]: values in quotes and text fields as one.
class CifWords {
public:
    struct Word {
        std::string_view text;
        std::size_t line = 0;
        bool is_quoted = false;

        bool is(std::string_view reserved) const { return !is_quoted && upper(text) == reserved; }
        bool starts(std::string_view reserved) const {
            return !is_quoted && upper(text.substr(0, reserved.size())) == reserved;
        }
        bool is_tag() const { return !is_quoted && text.starts_with('_'); }
        bool is_value() const {
            return !is_tag() && !is("LOOP_") && !starts("DATA_") && !starts("SAVE_") && !is("STOP_") &&
                   !is("GLOBAL_");
        }
        /// `?` and `.` are no values.
        bool is_unknown() const { return !is_quoted && (text == "?" || text == "."); }
    };

    explicit CifWords(std::string_view text) : text_(text) { advance(); }

    /// The word that is next; none at the end.
    const std::optional<Word>& peek() const { return word_; }
    Word next() {
        const Word word = *word_;
        advance();
        return word;
    }

private:
    static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

    void advance() {
        for (; at_ < text_.size(); ++at_) {
            if (text_[at_] == '#')
                at_ = std::min(text_.find('\n', at_), text_.size() - 1);
            else if (!is_blank(text_[at_]))
                break;
            if (text_[at_] == '\n') ++line_;
        }
        word_.reset();
        if (at_ >= text_.size()) return;
        word_ = Word{{}, line_, true};
        const char c = text_[at_];
        if (c == ';' && (at_ == 0 || text_[at_ - 1] == '\n')) {
            const std::size_t end = text_.find("\n;", at_);
            if (end == text_.npos) fail_line(line_, "this text field has no end");
            take(at_ + 1, end, end + 2);
        } else if (c == '\'' || c == '"') {
            std::size_t end = at_ + 1;
            while (end < text_.size() && text_[end] != '\n' &&
                   !(text_[end] == c && (end + 1 == text_.size() || is_blank(text_[end + 1]))))
                ++end;
            if (end == text_.size() || text_[end] == '\n') fail_line(line_, "this quotation has no end");
            take(at_ + 1, end, end + 1);
        } else {
            std::size_t end = at_;
            while (end < text_.size() && !is_blank(text_[end])) ++end;
            take(at_, end, end);
            word_->is_quoted = false;
        }
    }
    void take(std::size_t begin, std::size_t end, std::size_t next) {
        word_->text = text_.substr(begin, end - begin);
        line_ += static_cast<std::size_t>(std::ranges::count(text_.substr(at_, next - at_), '\n'));
        at_ = next;
    }

    std::string_view text_;
    std::size_t at_ = 0, line_ = 1;
    std::optional<Word> word_;
};

using Word = CifWords::Word;

// The table of atom_site: its columns' names, in small letters, and its rows one after the other.
struct AtomSites {
    std::vector<std::string> columns;
    std::vector<Word> values;
};

std::string column_name(const Word& tag) {
    std::string name(tag.text);
    std::ranges::transform(name, name.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    constexpr std::string_view category = "_atom_site.";
    return name.starts_with(category) ? name.substr(category.size()) : "";
}

AtomSites atom_sites(std::string_view text) {
    CifWords words(text);
    AtomSites sites;
    bool has_block = false;
    while (words.peek()) {
        const Word word = words.next();
        if (word.starts("DATA_")) {
            if (std::exchange(has_block, true)) break;
        } else if (word.is("LOOP_")) {
            std::vector<std::string> names;
            while (words.peek() && words.peek()->is_tag()) names.push_back(column_name(words.next()));
            if (names.empty()) fail_line(word.line, "this loop_ has no names");
            std::vector<Word> values;
            while (words.peek() && words.peek()->is_value()) values.push_back(words.next());
            if (values.size() % names.size() != 0)
                fail_line(word.line, fmt::format("this loop_ has {} values, no multiple of its {} names",
                                                 values.size(), names.size()));
            if (names.front().empty()) continue;
            if (!sites.columns.empty()) fail_line(word.line, "atom_site is there a second time");
            sites = {std::move(names), std::move(values)};
        } else if (word.is_tag()) {
            if (!words.peek() || !words.peek()->is_value())
                fail_line(word.line, fmt::format("{} has no value", printable(word.text)));
            const Word value = words.next();
            if (std::string name = column_name(word); !name.empty()) {
                sites.columns.push_back(std::move(name));
                sites.values.push_back(value);
            }
        } else if (!word.starts("SAVE_")) {
            fail_line(word.line, fmt::format("'{}' belongs to no name", printable(word.text)));
        }
    }
    return sites;
}

}  // namespace

BallFile parse_pdb(std::string_view text, const BallFileOptions& options) {
    const std::size_t wanted = options.frame.value_or(0);
    Molecule molecule(options);
    Lines lines(text);
    std::size_t models = 0;
    bool is_inside = false;  // of a model
    while (!lines.at_end()) {
        const std::string_view line = lines.next();
        const std::string_view record = columns(line, 1, 6);
        if (record == "END") break;
        if (record == "MODEL") {
            if (is_inside) fail_line(lines.number(), "this MODEL is inside another one");
            is_inside = true;
            ++models;
        } else if (record == "ENDMDL") {
            if (!std::exchange(is_inside, false)) fail_line(lines.number(), "no MODEL ends here");
        } else if (record == "ATOM" || record == "HETATM") {
            models = std::max<std::size_t>(models, 1);
            if (models - 1 == wanted) molecule.add(pdb_atom(line, lines.number()));
        } else if (!record.empty() && !other_records.contains(record)) {
            fail_line(lines.number(), fmt::format("'{}' is no record of a PDB file", printable(record)));
        }
    }
    if (wanted >= std::max<std::size_t>(models, 1)) fail_frame(models, wanted);
    return molecule.take();
}

BallFile parse_mmcif(std::string_view text, const BallFileOptions& options) {
    const AtomSites sites = atom_sites(text);
    const auto find = [&](std::initializer_list<const char*> names) -> std::optional<std::size_t> {
        for (const char* name : names)
            if (const auto at = std::ranges::find(sites.columns, name); at != sites.columns.end())
                return static_cast<std::size_t>(at - sites.columns.begin());
        return std::nullopt;
    };
    const auto require = [&](const char* name) {
        const std::optional<std::size_t> at = find({name});
        if (!at)
            throw InputError(InputError::Kind::MissingKey, InputError::no_object,
                             fmt::format("_atom_site.{}", name), "missing, and with it the atoms' places");
        return *at;
    };
    const std::array coordinates{require("cartn_x"), require("cartn_y"), require("cartn_z")};
    const std::size_t element = require("type_symbol");
    const auto hetero = find({"group_pdb"}), name = find({"auth_atom_id", "label_atom_id"}),
               location = find({"label_alt_id"}), residue = find({"auth_comp_id", "label_comp_id"}),
               chain = find({"auth_asym_id", "label_asym_id"}),
               number = find({"auth_seq_id", "label_seq_id"}), insertion = find({"pdbx_pdb_ins_code"}),
               model = find({"pdbx_pdb_model_num"});
    const std::size_t wanted = options.frame.value_or(0), width = sites.columns.size();
    Molecule molecule(options);
    std::vector<std::string_view> models;
    for (std::size_t row = 0; row < sites.values.size(); row += width) {
        const auto value = [&](std::optional<std::size_t> column) {
            if (!column) return std::string_view();
            const Word& word = sites.values[row + *column];
            return word.is_unknown() ? std::string_view() : word.text;
        };
        const std::string_view this_model = value(model);
        if (std::ranges::find(models, this_model) == models.end()) models.push_back(this_model);
        if (wanted >= models.size() || models[wanted] != this_model) continue;
        Atom atom;
        atom.line = sites.values[row].line;
        for (int k = 0; k < 3; ++k) {
            const Word& word = sites.values[row + coordinates[static_cast<std::size_t>(k)]];
            if (word.is_unknown()) fail_line(word.line, fmt::format("Cartn_{} is not known", "xyz"[k]));
            // A standard uncertainty may follow, in parentheses.
            const std::size_t open = word.text.find('(');
            atom.center[k] = parse_number(word.text.substr(0, open), word.line);
        }
        atom.element = value(element);
        atom.is_hetero = value(hetero) == "HETATM";
        atom.name = value(name);
        atom.location = value(location);
        atom.residue = value(residue);
        atom.chain = value(chain);
        atom.number = value(number);
        atom.insertion = value(insertion);
        molecule.add(atom);
    }
    if (wanted >= std::max<std::size_t>(models.size(), 1)) fail_frame(models.size(), wanted);
    return molecule.take();
}

}  // namespace vcell
