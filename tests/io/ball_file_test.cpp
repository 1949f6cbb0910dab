// Files of balls that other programs write.
#include "../../io/files/ball_file.hpp"

#include <doctest/doctest.h>

#include <Eigen/LU>
#include <array>
#include <random>
#include <string>

#include "../../core/errors.hpp"
#include "../../io/files/diagram_file.hpp"
#include "../../io/files/element_radii.hpp"
#include "../../io/files/files.hpp"
#include "../../io/files/scene_file.hpp"
#include "../test_support.hpp"

namespace vcell {
namespace {

BallFile read(const std::string& text, const BallFileOptions& options = {}) {
    const std::optional<BallFile> file = parse_ball_file(text, options);
    REQUIRE(file.has_value());
    return *file;
}

std::string complaint(const std::string& text, const BallFileOptions& options = {}) {
    try {
        parse_ball_file(text, options);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

std::string pdb_line(const std::string& record, const std::string& name, const std::string& residue,
                     const std::string& number, const std::string& place, const std::string& element) {
    const auto pad = [](std::string text, std::size_t width) {
        text.resize(width, ' ');
        return text;
    };
    return pad(record, 6) + "    1 " + pad(name, 5) + pad(residue, 3) + " A" + number + "    " + place +
           "  1.00  0.00          " + element + "\n";
}
const std::string origin = "   0.000   0.000   0.000";

// A dump of two frames.
std::string dump(const std::string& bounds, const std::string& columns, const std::string& atoms,
                 const std::string& count = "2") {
    return "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ATOMS id type "
           "x y z radius\n7 1 0.5 0.5 0.5 0.25\nITEM: TIMESTEP\n100\nITEM: NUMBER OF ATOMS\n" +
           count + "\nITEM: BOX BOUNDS " + bounds + "\nITEM: ATOMS " + columns + "\n" + atoms;
}
BallFileOptions second_frame() {
    BallFileOptions options;
    options.frame = 1;
    return options;
}

}  // namespace

TEST_CASE("ball file: PDB and mmCIF have the same atoms, those of the x y z r file") {
    const BallFile pdb = read(read_file(test_data("crambin_head.pdb"))),
                   cif = read(read_file(test_data("crambin_head.cif")));
    const DiagramScene all = read_diagram_scene(test_data("1CRN.xyzr"));
    REQUIRE(pdb.balls.size() == 26);
    REQUIRE(cif.balls.size() == 26);
    for (std::size_t i = 0; i < 26; ++i) {
        CHECK(Object(pdb.balls[i]) == all.objects[i]);
        CHECK(cif.balls[i] == pdb.balls[i]);
    }
    CHECK(pdb.names[5] == "A:THR1:OG1");
    CHECK(pdb.names == cif.names);
    CHECK(pdb.groups == cif.groups);
    CHECK(pdb.groups[25] == "A:CYS4");
    CHECK(!pdb.box);
    BallFileOptions options;
    options.group = BallFileOptions::Group::Chain;
    CHECK(read(read_file(test_data("crambin_head.pdb")), options).groups[25] == "A");
}

TEST_CASE("ball file: PDB atoms are chosen by element, residue, record and alternate location") {
    const std::string text = "MODEL        1\n" + pdb_line("ATOM", " N", "THR", "   1", origin, " N") +
                             pdb_line("ATOM", " CA A", "THR", "   1", "   1.000   0.000   0.000", " C") +
                             pdb_line("ATOM", " CA B", "THR", "   1", "   1.100   0.000   0.000", " C") +
                             pdb_line("ATOM", " HA", "THR", "   1", "   2.000   0.000   0.000", " H") +
                             pdb_line("HETATM", "FE", "HEM", "   2", "   3.000   0.000   0.000", "FE") +
                             pdb_line("HETATM", " O", "HOH", "   3", "   4.000   0.000   0.000", " O") +
                             "ENDMDL\nMODEL        2\n" +
                             pdb_line("ATOM", " N", "THR", "   1", "   0.000   9.000   0.000", " N") +
                             "ENDMDL\nEND\n";
    const BallFile usual = read(text);
    REQUIRE(usual.balls.size() == 4);
    CHECK(usual.balls[1].center.x() == 1);
    CHECK(usual.balls[2].radius == 2.44);
    CHECK(usual.names[3] == "A:HOH3:O");
    BallFileOptions options;
    options.has_hydrogens = true;
    CHECK(read(text, options).balls.size() == 5);
    options.leaves_water = true;
    CHECK(read(text, options).balls.size() == 4);
    options.leaves_hetero = true;
    CHECK(read(text, options).balls.size() == 3);
    const BallFile second = read(text, second_frame());
    REQUIRE(second.balls.size() == 1);
    CHECK(second.balls[0].center.y() == 9);
    options.frame = 2;
    CHECK(complaint(text, options) == "--frame: must be less than the number of frames, 2, is 2");
}

TEST_CASE("ball file: where PDB columns 77 and 78 are blank the name says the element") {
    const auto radius = [](const std::string& name) {
        BallFileOptions options;
        options.has_hydrogens = true;
        return read(pdb_line("ATOM", name, "THR", "   1", origin, "  "), options).balls.at(0).radius;
    };
    CHECK(radius(" CA") == 1.70);   // a carbon
    CHECK(radius("CA") == 2.62);    // calcium
    CHECK(radius("HG21") == 1.20);  // a hydrogen, not mercury
    CHECK(radius("HG") == 1.55);
    CHECK(radius("1HB") == 1.20);
    CHECK(complaint(pdb_line("ATOM", "QQ", "THR", "   1", origin, "  ")) ==
          "line 1: there is no radius of 'QQ' in the table; --radius QQ=R gives one");
    BallFileOptions options;
    options.radii = {{"QQ", 2.5}, {"C", 2}};
    CHECK(read(pdb_line("ATOM", "QQ", "THR", "   1", origin, "  "), options).balls[0].radius == 2.5);
    CHECK(read(pdb_line("ATOM", " CA", "THR", "   1", origin, " C"), options).balls[0].radius == 2);
}

TEST_CASE("ball file: mistakes in PDB files are named by line") {
    const std::string good = pdb_line("ATOM", " N", "THR", "   1", origin, " N");
    CHECK(complaint(good + "ATOM      2  CA  THR A   1      16.967\n") ==
          "line 2: a PDB atom's coordinates end in column 54, the line in column 38");
    CHECK(complaint(good + pdb_line("ATOM", " CA", "THR", "   1", "   1.0x0   0.000   0.000", " C")) ==
          "line 2: '1.0x0' is not a number");
    CHECK(complaint(good + pdb_line("ATOM", " CA", "THR", "   1", "   0.000           0.000", " C")) ==
          "line 2: y is missing in columns 39 to 46");
    CHECK(complaint(good + pdb_line("ATOM", " CA", "THR", "   1", origin, "ZZ"))
              .starts_with("line 2: there is no radius of 'ZZ'"));
    CHECK(complaint(good + "ATMO      2\n") == "line 2: 'ATMO' is no record of a PDB file");
    CHECK(complaint("MODEL        1\nMODEL        2\n") == "line 2: this MODEL is inside another one");
    CHECK(complaint(good + "ENDMDL\n") == "line 2: no MODEL ends here");
    CHECK(complaint("HEADER    NOTHING\n") == "there is no atom among what is read");
}

TEST_CASE("ball file: mmCIF's words, in quotes and text fields, and single atoms") {
    const std::string one =
        "data_x\n_a.text\n;_atom_site.Cartn_x 1\nloop_\n;\n_b.c 'it''s a loop_' # comment\n"
        "_atom_site.group_PDB HETATM\n_atom_site.type_symbol FE _atom_site.Cartn_x 1.5(2)\n"
        "_atom_site.Cartn_y -2 _atom_site.Cartn_z \"3\" _atom_site.label_atom_id FE _atom_site.label_comp_id HEM\n"
        "_atom_site.label_asym_id B _atom_site.label_seq_id .\ndata_y _atom_site.Cartn_x 7\n";
    const BallFile file = read("# first\n\n" + one);
    REQUIRE(file.balls.size() == 1);
    CHECK(file.balls[0] == Sphere{{1.5, -2, 3}, 2.44});
    CHECK(file.names[0] == "B:HEM:FE");
    const std::string head =
        "data_x\nloop_\n_atom_site.type_symbol\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n";
    CHECK(read(head + "C 1 2 3\nN 4 5 6\n").balls.size() == 2);
    CHECK(complaint(head + "C 1 2 3\nN 4 5\n") ==
          "line 2: this loop_ has 7 values, no multiple of its 4 names");
    CHECK(complaint(head + "C 1 2 3\nN 4 ? 6\n") == "line 8: Cartn_y is not known");
    CHECK(complaint(head + "C 1 2 3\nN 4 5,0 6\n") == "line 8: '5,0' is not a number");
    CHECK(complaint(head + "C 1 2 3\nQ 4 5 6\n").starts_with("line 8: there is no radius of 'Q'"));
    CHECK(complaint(head + "C 1 2 3\nN 4 'five 6\n") == "line 8: this quotation has no end");
    CHECK(complaint("data_x\n_a.b\n;text\n") == "line 3: this text field has no end");
    CHECK(complaint("data_x\n_a.b\n_a.c 1\n") == "line 2: _a.b has no value");
    CHECK(complaint("data_x\n_a.b 1 2\n") == "line 2: '2' belongs to no name");
    CHECK(complaint("data_x\n_atom_site.fract_x 0.5\n") ==
          "_atom_site.cartn_x: missing, and with it the atoms' places");
}

TEST_CASE("ball file: mmCIF models, locations and unknown chains") {
    const std::string text =
        "data_x\nloop_\n_atom_site.type_symbol\n_atom_site.label_alt_id\n_atom_site.auth_seq_id\n"
        "_atom_site.pdbx_PDB_model_num\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n"
        "C . 1 1 0 0 0\nC B 1 1 1 0 0\nC A 1 1 2 0 0\nC A 2 1 3 0 0\nC . 1 2 4 0 0\nN . 1 2 5 0 0\n";
    CHECK(read(text).balls.size() == 3);
    CHECK(read(text).balls[2].center.x() == 3);
    CHECK(read(text, second_frame()).balls.size() == 2);
}

TEST_CASE("ball file: XYZ, plain and extended") {
    const BallFile plain = read("2\nwater, perhaps\nO 0 0 0\nFe 1 2 3\n\n");
    REQUIRE(plain.balls.size() == 2);
    CHECK(plain.balls[1] == Sphere{{1, 2, 3}, 2.44});
    CHECK(plain.names[1] == "Fe");
    CHECK(!plain.box);
    const BallFile box = read(
        "1\nLattice=\"4 0 0 1 5 0 0.5 0.25 6\" Origin=\"1 2 3\" energy=-7 Properties=id:I:1:species:S:1:forces:R:3:pos:"
        "R:3:radius:R:1 note={a b}\n12 C 0 0 0 1 2 3 0.5\n");
    REQUIRE(box.box.has_value());
    CHECK(box.box->min == Vec3(1, 2, 3));
    CHECK(box.box->max == Vec3(5, 7, 9));
    CHECK(box.tilt == std::array{1.0, 0.5, 0.25});
    CHECK(box.periodic == std::array{true, true, true});
    CHECK(box.balls[0] == Sphere{{1, 2, 3}, 0.5});
    CHECK(box.names[0] == "12");
    const std::string frames = "1\n\nC 0 0 0\n1\nLattice=\"4 0 0 0 5 0 0 0 6\" pbc=\"T F T\"\nN 1 1 1\n";
    CHECK(read(frames).balls[0].radius == 1.70);
    const BallFile second = read(frames, second_frame());
    CHECK(second.balls[0].radius == 1.55);
    CHECK(second.periodic == std::array{true, false, true});
    // Other programs leave blanks around the sign.
    CHECK(read("1\nLattice = \"4 0 0 0 5 0 0 0 6\" pbc= \"T F T\"\nC 0 0 0\n").periodic ==
          std::array{true, false, true});
    CHECK(!read("1\nLattice of nothing = \"4\nC 0 0 0\n").box);
    // fcc's vectors are turned: lengths, angles and distances stay.
    const BallFile turned = read("1\nLattice=\"0 2 2 2 0 2 2 2 0\" Origin=\"1 0 0\"\nC 1 0.5 0.25\n");
    const Eigen::Matrix3d edges =
        (Eigen::Matrix3d() << turned.box->max.x() - turned.box->min.x(), turned.tilt[0], turned.tilt[1], 0,
         turned.box->max.y() - turned.box->min.y(), turned.tilt[2], 0, 0,
         turned.box->max.z() - turned.box->min.z())
            .finished();
    const Eigen::Matrix3d lattice = (Eigen::Matrix3d() << 0, 2, 2, 2, 0, 2, 2, 2, 0).finished();
    CHECK((edges.transpose() * edges - lattice.transpose() * lattice).norm() < 1e-14);
    CHECK((edges.inverse() * (turned.balls[0].center - turned.box->min) -
           lattice.inverse() * Vec3(0, 0.5, 0.25))
              .norm() < 1e-14);
}

TEST_CASE("ball file: mistakes in XYZ files are named by line") {
    CHECK(complaint("2\n\nC 0 0 0\n") == "line 4: an atom is missing");
    CHECK(complaint("2\n\nC 0 0 0\nC 0 0\n") == "line 4: must be species x y z, has 3 words instead of 4");
    CHECK(complaint("1\n\nC 0 0 zero\n") == "line 3: 'zero' is not a number");
    CHECK(complaint("1\n\nXx 0 0 0\n").starts_with("line 3: there is no radius of 'Xx'"));
    CHECK(complaint("1\nLattice=\"1 2 3\"\nC 0 0 0\n") == "line 2: Lattice must have 9 numbers, has 3");
    CHECK(complaint("1\nLattice=\"1 2 3\nC 0 0 0\n") == "line 2: the value of Lattice has no end");
    CHECK(complaint("1\nLattice=\"0 1 0 1 0 0 0 0 1\"\nC 0 0 0\n") ==
          "line 2: Lattice: its vectors must be right-handed and span a volume");
    CHECK(complaint("1\nLattice=\"1 0 0 0 1 0 0 0 1\" pbc=\"T yes F\"\nC 0 0 0\n") ==
          "line 2: pbc: must be T or F three times, has 'yes'");
    CHECK(complaint("1\nProperties=species:S:1 pbc=\"T T T\"\nC\n") == "line 2: Properties: pos is missing");
    CHECK(complaint("1\nProperties=pos:R:3\n0 0 0\n") ==
          "line 2: Properties: there is neither a radius nor a species");
    CHECK(complaint("1\nProperties=pos:R:2:species:S:1\n0 0 C\n") == "line 2: Properties: pos must be R:3");
    CHECK(complaint("1\nProperties=species:S:1:pos:R:3 pbc=\"T T T\"\nC 0 0 0\n") ==
          "line 2: pbc: a box that repeats needs a Lattice");
    CHECK(complaint("1\nProperties=id:I:0:pos:R:3:radius:R:1\n0 0 0 1\n") ==
          "line 2: Properties: id must be one column");
    CHECK(complaint("1\nProperties=pos:R:3:radius:R:1:pos:R:3\n0 0 0 1 2 2 2\n") ==
          "line 2: Properties: pos is there twice");
    CHECK(complaint("1\nProperties=pos:R:3:radius:R:x\n0 0 0 1\n") ==
          "line 2: must be a number of columns, is 'x'");
    CHECK(complaint("1\nProperties=pos:R:3:radius:R:1\n0 0 0 -1\n") ==
          "line 3: a radius must be >= 0, is -1");
    CHECK(complaint("1\n\nC 0 0 0\n\nC 1 1 1\n") ==
          "line 5: must begin another frame, as all 1 atoms of this one are before it, is 'C 1 1 1'");
    CHECK(complaint("1\n\nC 0 0 0\n2\n\n") == "");
    CHECK(complaint("1\n\nC 0 0 0\n", second_frame()) ==
          "--frame: must be less than the number of frames, 1, is 1");
}

TEST_CASE("ball file: LAMMPS dumps, boxes that lean, scaled places, radii and types") {
    const BallFile first = read(dump("pp pp pp\n0 1\n0 1\n0 1", "x y z radius", "0 0 0 1\n"));
    REQUIRE(first.balls.size() == 1);
    CHECK(first.balls[0] == Sphere{{0.5, 0.5, 0.5}, 0.25});
    CHECK(first.names[0] == "7");
    CHECK(first.periodic == std::array{false, false, false});
    // The corners of the box around a box with edges (4,0,0), (-1,5,0), (0.5,2,6) at (1,2,3).
    const BallFile leaning =
        read(dump("xy xz yz pp pp pp\n0 5.5 -1\n2 9 0.5\n3 9 2", "id mol type xs ys zs diameter",
                  "1 4 1 0.5 0.5 0.5 3\n2 4 1 0 0 1 1\n"),
             second_frame());
    CHECK(leaning.box->min == Vec3(1, 2, 3));
    CHECK(leaning.box->max == Vec3(5, 7, 9));
    CHECK(leaning.tilt == std::array{-1.0, 0.5, 2.0});
    CHECK(leaning.periodic == std::array{true, true, true});
    CHECK(leaning.balls[0] == Sphere{{1 + 2 - 0.5 + 0.25, 2 + 2.5 + 1, 6}, 1.5});
    CHECK(leaning.balls[1] == Sphere{{1.5, 4, 9}, 0.5});
    CHECK(leaning.groups == std::vector<std::string>{"4", "4"});
    BallFileOptions types = second_frame();
    types.radii = {{"1", 0.125}, {"2", 0.25}};
    const BallFile by_type =
        read(dump("pp ff fs\n0 1\n0 1\n0 1", "type xu yu zu", "1 0 0 0\n2 1 1 1\n"), types);
    CHECK(by_type.balls[1].radius == 0.25);
    CHECK(by_type.periodic == std::array{true, false, false});
    CHECK(read(dump("pp pp pp\n0 1\n0 1\n0 1", "element x y z", "O 0 0 0\nC 1 1 1\n"), second_frame())
              .balls[0]
              .radius == 1.52);
}

TEST_CASE("ball file: mistakes in dumps are named by line") {
    const auto wrong = [](const std::string& bounds, const std::string& columns, const std::string& atoms) {
        return complaint(dump(bounds, columns, atoms), second_frame());
    };
    const std::string cube = "pp pp pp\n0 1\n0 1\n0 1";
    CHECK(wrong(cube, "id x y z radius", "1 0 0 0 1\n2 0 0 0\n") == "line 21: must have 5 columns, has 4");
    CHECK(wrong(cube, "id x y z radius", "1 0 0 0 1\n") == "line 21: an atom is missing");
    CHECK(wrong(cube, "id x y z radius", "1 0 0 0 1\n2 0 a 0 1\n") == "line 21: 'a' is not a number");
    CHECK(wrong(cube, "id x y radius", "") ==
          "line 19: among the columns must be x y z, xu yu zu, xs ys zs or xsu ysu zsu");
    CHECK(wrong(cube, "id x y z", "") ==
          "line 19: among the columns must be radius, diameter, element or type");
    CHECK(wrong(cube, "type x y z", "A 0 0 0\n").starts_with("line 20: there is no radius of 'A'"));
    CHECK(wrong("pp pp\n0 1\n0 1\n0 1", "x y z radius", "")
              .starts_with("line 15: BOX BOUNDS must be followed by"));
    CHECK(wrong("pp pp px\n0 1\n0 1\n0 1", "x y z radius", "") == "line 15: 'px' is no flag of an axis");
    CHECK(wrong("pp pp pp\n0 1\n0 1 2\n0 1", "x y z radius", "") == "line 17: must have 2 numbers, has 3");
    CHECK(complaint("ITEM: TIMESTEP\n0\nITEM: NUMBERS\n") == "line 3: 'ITEM: NUMBERS' is no item of a dump");
    CHECK(complaint("ITEM: TIMESTEP\n0\nITEM: ATOMS x y z radius\n") ==
          "line 3: atoms come after their number and the BOX BOUNDS");
    CHECK(wrong(cube, "id x y z radius", "1 0 0 0 1\n2 0 0 0 1\n3 0 0 0 1\n") ==
          "line 22: must begin another frame, as all 2 atoms of this one are before it, is '3 0 0 0 1'");
    CHECK(wrong(cube, "id x y z diameter", "1 0 0 0 1\n2 0 0 0 -1\n") ==
          "line 21: a radius must be >= 0, is -1");
    CHECK(complaint("ITEM: TIMESTEP\nnow\n") == "line 2: must be a timestep, is 'now'");
    CHECK(complaint("ITEM: NUMBER OF ATOMS\n0\n") == "line 1: a dump begins with ITEM: TIMESTEP");
}

TEST_CASE("ball file: damaged files are read or refused by line, and nothing else") {
    const std::array<std::string, 4> texts{
        read_file(test_data("crambin_head.pdb")), read_file(test_data("crambin_head.cif")),
        "2\nLattice=\"4 0 0 1 5 0 0.5 0.25 6\" pbc=\"T T F\" Properties=species:S:1:pos:R:3:radius:R:1\nC 0 0 0 1\nO 1 1 1 1\n",
        dump("xy xz yz pp pp pp\n0 5.5 -1\n2 9 0.5\n3 9 2", "id mol type xs ys zs diameter",
             "1 4 1 0.5 0.5 0.5 3\n2 4 1 0 0 1 1\n")};
    std::mt19937_64 rng(test_seed());
    int read_ones = 0, refused = 0;
    for (const std::string& text : texts)
        for (int i = 0; i < 500 * rounds(); ++i) {
            std::string damaged = text;
            for (int k = 0; k < 3 && !damaged.empty(); ++k) {
                const std::size_t at = rng() % damaged.size();
                switch (rng() % 4) {
                    case 0: damaged[at] = static_cast<char>(rng() % 256); break;
                    case 1: damaged.erase(at, rng() % 9); break;
                    case 2: damaged.insert(at, damaged.substr(rng() % damaged.size(), rng() % 9)); break;
                    default: damaged.resize(at + 1); break;
                }
            }
            try {
                parse_ball_file(damaged);
                ++read_ones;
            } catch (const InputError& e) {
                CHECK(!std::string(e.what()).empty());
                ++refused;
            }
        }
    CHECK(read_ones > 0);
    CHECK(refused > 0);
}

TEST_CASE("ball file: other texts are left to others, and options without a use are refused") {
    CHECK(!parse_ball_file("# x y z r\n0 0 0 1\n"));
    CHECK(!parse_ball_file("{\"vcell\": 1}"));
    CHECK(complaint("\x1F\x8B\x08").find("gzip") != std::string::npos);
    BallFileOptions options;
    options.leaves_water = true;
    CHECK(complaint("1\n\nC 0 0 0\n", options) == "--no-water: is for PDB and mmCIF files");
    options = {};
    options.radii = {{"C", 1}};
    CHECK(complaint("0 0 0 1\n", options) == "--radius: is for PDB, mmCIF, XYZ and LAMMPS dump files");
}

TEST_CASE("ball file: cells of one atom, and no cell of one in a box that repeats") {
    TextSceneOptions options;
    options.base_ball = 3;
    const Scene scene = read_scene(test_data("crambin_head.pdb"), options);
    CHECK(scene.base == scene.objects[3]);
    CHECK(scene.base_name == "A:THR1:O");
    CHECK(scene.units == "angstrom");
    options.base_ball = 0;
    CHECK_THROWS_WITH_AS(parse_scene("1\nLattice=\"4 0 0 0 4 0 0 0 4\"\nC 0 0 0\n", options),
                         "the box of this file repeats; vcell diagram computes its cells", InputError);
}

TEST_CASE("ball file: the radii are those of the published tables") {
    CHECK(element_radius("C") == 1.70);
    CHECK(element_radius("CL") == 1.75);
    CHECK(element_radius("cl") == 1.75);
    CHECK(element_radius("D") == element_radius("H"));
    CHECK(element_radius("Fe") == 2.44);
    CHECK(!element_radius("Xx"));
    CHECK(!element_radius(""));
}

}  // namespace vcell
