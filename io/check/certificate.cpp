#include "certificate.hpp"

#include <cmath>
#include <utility>

#include "../files/json_writer.hpp"

namespace vcell {

std::string_view to_string(Verdict verdict) {
    switch (verdict) {
        case Verdict::proved: return "proved";
        case Verdict::refuted: return "refuted";
        default: return "open";
    }
}

void Certificate::add(Element element) {
    ++counts_[static_cast<std::size_t>(element.verdict)];
    elements.push_back(std::move(element));
}
void Certificate::prove(std::string where, double amount, std::string what) {
    add({std::move(where), Verdict::proved, std::move(what), amount});
}
void Certificate::refute(std::string where, std::string what, double amount) {
    add({std::move(where), Verdict::refuted, std::move(what), amount});
}
void Certificate::leave_open(std::string where, std::string what, double amount) {
    add({std::move(where), Verdict::open, std::move(what), amount});
}

void write_certificate(std::ostream& out, const Certificate& c) {
    JsonWriter json(out);
    const auto amount = [&](double v) {  // JSON has no word for an infinite one
        if (std::isfinite(v))
            json.value(v);
        else
            json.null();
    };
    json.object([&] {
        json.key("vcell").value(1);
        json.line_key("holds").value(c.holds());
        json.line_key("distance");
        amount(c.distance);
        for (const Verdict v : {Verdict::proved, Verdict::refuted, Verdict::open})
            json.line_key(to_string(v)).value(std::uint64_t{c.count(v)});
        json.line_key("elements").lines(c.elements, [&](const Element& e) {
            json.object([&] {
                json.key("where").value(e.where);
                json.key("verdict").value(to_string(e.verdict));
                json.key("amount");
                amount(e.amount);
                if (!e.what.empty()) json.key("what").value(e.what);
            });
        });
    });
    json.finish();
    out << '\n';
}

}  // namespace vcell
