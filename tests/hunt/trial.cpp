#include "trial.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <csignal>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <new>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "../../core/errors.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../../io/files/stored_diagram.hpp"
#include "families.hpp"

namespace vcell::hunt {

const char* to_string(Outcome outcome) {
    constexpr std::array<const char*, outcome_count> names{"proved",    "assumed", "open",     "undecided",
                                                           "illegal",   "wrong",   "internal", "too long",
                                                           "too large", "crash"};
    return names[static_cast<std::size_t>(outcome)];
}

namespace {

// This tells the worst that a certificate finds, if anything.
std::optional<Trial> fault_in(const Certificate& certificate) {
    for (const auto& [verdict, outcome] :
         {std::pair(Verdict::refuted, Outcome::Wrong), std::pair(Verdict::open, Outcome::Open)}) {
        const auto at = std::ranges::find(certificate.elements, verdict, &Element::verdict);
        if (at != certificate.elements.end()) return Trial{outcome, at->where + ": " + at->what};
    }
    return std::nullopt;
}

Trial judge_cell(const Scene& scene) {
    const Cell cell = voronoi_cell(scene);
    if (const auto fault = fault_in(certify(cell))) return *fault;
    if (cell.report.decisions.assumed == 0) return {Outcome::Proved, {}};
    return {Outcome::Assumed, cell.report.warnings.empty() ? "nothing listed" : cell.report.warnings.back()};
}

Trial judge_diagram(const DiagramScene& scene) {
    std::ostringstream file;
    DiagramWriter writer(file, scene);
    DiagramOptions options;
    options.complete = true;
    options.visit = [&](std::uint32_t object, const Cell& cell) { writer.add(object, cell); };
    const VoronoiDiagram diagram = voronoi_diagram(scene, options);
    writer.finish(diagram);
    const std::optional<StoredDiagram> stored = parse_diagram(file.str());
    if (!stored) return {Outcome::Internal, "the file is none of a diagram"};
    const std::optional<Trial> fault = fault_in(certify(*stored));
    if (fault && fault->outcome == Outcome::Wrong) return *fault;

    std::optional<Trial> lack;
    bool is_assumed = false;
    for (std::uint32_t i = 0; i < diagram.cells.size(); ++i) {
        const DiagramCell& cell = diagram.cells[i];
        const std::string what = fmt::format("objects[{}]: {}", i, cell.reason);
        if (cell.reason.starts_with("internal error")) return {Outcome::Internal, what};
        if (cell.state == DiagramCell::State::Refused) lack = {Outcome::Illegal, what};
        if (cell.state == DiagramCell::State::Undecided && !lack) lack = {Outcome::Undecided, what};
        is_assumed = is_assumed || cell.assumed > 0;
    }
    if (lack) return *lack;
    if (!stored->lacking.empty())
        return {Outcome::Undecided, fmt::format("objects[{}]: {}", stored->lacking.front().object,
                                                stored->lacking.front().reason)};
    if (fault) return *fault;
    return {is_assumed ? Outcome::Assumed : Outcome::Proved, {}};
}

Trial without_exceptions(const std::function<Trial()>& judge) try {
    return judge();
} catch (const UndecidedError& e) {
    return {Outcome::Undecided, e.what()};
} catch (const InputError& e) {
    return {Outcome::Illegal, e.what()};
} catch (const std::bad_alloc&) {
    return {Outcome::TooLarge, "out of memory"};
} catch (const std::exception& e) {
    return {Outcome::Internal, e.what()};
}

std::uint64_t address_space() {
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

[[noreturn]] void answer(int pipe_end, const std::function<Trial()>& judge, const Limits& limits) {
    const rlimit time{limits.seconds, limits.seconds + 1}, no_core{0, 0};
    setrlimit(RLIMIT_CPU, &time);
    setrlimit(RLIMIT_CORE, &no_core);
#ifndef __SANITIZE_ADDRESS__  // whose shadow memory is larger than any limit
    const rlim_t most = address_space() + (limits.megabytes << 20);
    const rlimit space{most, most};
    setrlimit(RLIMIT_AS, &space);
#endif
    const Trial trial = without_exceptions(judge);
    const std::string text = static_cast<char>('0' + static_cast<int>(trial.outcome)) + trial.what;
    std::size_t written = 0;
    while (written < text.size()) {
        const ssize_t n = write(pipe_end, text.data() + written, text.size() - written);
        if (n <= 0) break;
        written += static_cast<std::size_t>(n);
    }
    _exit(0);
}

Trial in_own_process(const std::function<Trial()>& judge, const Limits& limits) {
    std::fflush(nullptr);
    int ends[2];
    if (pipe(ends) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
    const pid_t child = fork();
    if (child < 0) throw std::system_error(errno, std::generic_category(), "fork");
    if (child == 0) {
        close(ends[0]);
        answer(ends[1], judge, limits);
    }
    close(ends[1]);
    std::string text;
    char buffer[4096];
    for (ssize_t n; (n = read(ends[0], buffer, sizeof buffer)) > 0;)
        text.append(buffer, static_cast<std::size_t>(n));
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    if (WIFSIGNALED(status)) {
        const int signal = WTERMSIG(status);
        if (signal == SIGXCPU || signal == SIGKILL)
            return {Outcome::TooLong, "over " + std::to_string(limits.seconds) + " s"};
        return {Outcome::Crash, strsignal(signal)};
    }
    if (text.empty()) return {Outcome::Crash, "no answer"};
    return {static_cast<Outcome>(text[0] - '0'), text.substr(1)};
}

void for_each_number(Object& o, const std::function<void(double&)>& visit) {
    const auto each = [&](Vec3& v) {
        for (double& x : v) visit(x);
    };
    if (auto* s = std::get_if<Sphere>(&o)) each(s->center), visit(s->radius);
    if (auto* p = std::get_if<Plane>(&o)) each(p->point), each(p->normal);
    if (auto* c = std::get_if<Cylinder>(&o)) each(c->point), each(c->axis), visit(c->radius);
    if (auto* s = std::get_if<HollowSphere>(&o)) each(s->center), visit(s->radius);
    if (auto* c = std::get_if<HollowCylinder>(&o)) each(c->point), each(c->axis), visit(c->radius);
    if (auto* c = std::get_if<HollowCone>(&o))
        each(c->apex), each(c->axis), visit(c->radius), visit(c->slant);
}

double shortened(double x, int digits) {
    char text[40];
    std::snprintf(text, sizeof text, "%.*g", digits, x);
    return std::strtod(text, nullptr);
}

Object* base_of(Scene& scene) { return &scene.base; }
Object* base_of(DiagramScene&) { return nullptr; }

bool may_be_judged(const Scene& scene) { return is_legal(scene); }
bool may_be_judged(const DiagramScene&) { return true; }

template <class AnyScene>
AnyScene made_small(AnyScene scene, const Trial& trial, const Limits& limits) {
    const auto still_fails = [&](const AnyScene& s) {
        return may_be_judged(s) && judge(s, limits).outcome == trial.outcome;
    };
    for (std::size_t i = scene.objects.size(); i-- > 0;) {
        AnyScene fewer = scene;
        fewer.objects.erase(fewer.objects.begin() + static_cast<std::ptrdiff_t>(i));
        if (still_fails(fewer)) scene = std::move(fewer);
    }
    for (std::size_t i = 0; i <= scene.objects.size(); ++i)  // the base last
        for (const int digits : {1, 2, 3, 6}) {
            AnyScene shorter = scene;
            Object* object = i < scene.objects.size() ? &shorter.objects[i] : base_of(shorter);
            if (object == nullptr) break;
            for_each_number(*object, [&](double& x) { x = shortened(x, digits); });
            if (!still_fails(shorter)) continue;
            scene = std::move(shorter);
            break;
        }
    return scene;
}

}  // namespace

Trial judge(const Scene& scene, const Limits& limits) {
    return in_own_process([&] { return judge_cell(scene); }, limits);
}
Trial judge(const DiagramScene& scene, const Limits& limits) {
    return in_own_process([&] { return judge_diagram(scene); }, limits);
}

Scene minimised(Scene scene, const Trial& trial, const Limits& limits) {
    return made_small(std::move(scene), trial, limits);
}
DiagramScene minimised(DiagramScene scene, const Trial& trial, const Limits& limits) {
    return made_small(std::move(scene), trial, limits);
}

}  // namespace vcell::hunt
