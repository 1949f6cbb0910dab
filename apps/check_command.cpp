#include "check_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <ostream>
#include <variant>

#include "../io/files/cell_file.hpp"
#include "../io/files/files.hpp"
#include "../io/files/stored_diagram.hpp"

namespace vcell {

namespace {

void write_verdicts(std::ostream& out, const std::string& what, const Certificate& certificate) {
    for (const Element& e : certificate.elements)
        if (e.verdict != Verdict::proved)
            out << e.where << (e.verdict == Verdict::open ? ": open: " : ": ") << e.what << '\n';
    if (certificate.holds())
        out << fmt::format("ok: {}; the boundary is within {:.3g} of the true one\n", what,
                           certificate.distance);
}

}  // namespace

CheckCommand::CheckCommand(CLI::App& app)
    : command_(*app.add_subcommand("check", "prove a file of a cell or a diagram from the scene in it")) {
    command_.add_option("CELL", path_, "file of a cell or a diagram, JSON; - is standard input")->required();
    command_
        .add_option("--effort", options_.effort,
                    "how far curves and patches are subdivided: twice as many parts with each step")
        ->check(CLI::Range(0, 40))
        ->capture_default_str();
    threads_.add_to(command_);
    command_.add_flag("--json", json_, "write the certificate: a verdict for each element");
    command_.footer(
        "Proves that the boundary as written lies everywhere within a distance of the true one, and prints\n"
        "that distance; or a line for each element that is refuted or left open. Of a diagram also that cells\n"
        "agree about what they share, and fill their box if all objects have cells. Exit status 4 if there is\n"
        "such a line: what is open has not been shown to be wrong, but not to be right, either.\n\n"
        "Examples:\n"
        "  vcell compute examples/scenes/figure8.json -o - | vcell check -\n"
        "  vcell diagram tests/data/1CRN.xyzr -o all.json && vcell check all.json");
}

Status CheckCommand::run() const {
    Certificate certificate;
    std::string what;
    about_file(path_, "", [&] {
        const std::string text = read_file(path_);
        if (const auto diagram = parse_diagram(text)) {
            certificate = certify(*diagram, options_, threads_.count());
            const bool fills = certificate.elements.back().what.empty();
            what = fmt::format("{} cells {}", diagram->cells.size(),
                               fills                  ? "that fill their box"
                               : diagram->scene.probe ? "up to a probe's distance"
                                                      : "among other objects");
        } else {
            const Cell cell = parse_cell(text);
            certificate = certify(cell, options_);
            what = fmt::format("{} faces, {} edges, {} vertices", cell.faces.size(), cell.edges.size(),
                               cell.vertices.size());
        }
    });
    OutputFile out("-");
    if (json_)
        write_certificate(out.stream(), certificate);
    else
        write_verdicts(out.stream(), what, certificate);
    out.commit();
    return certificate.holds() ? done : check_failed;
}

}  // namespace vcell
