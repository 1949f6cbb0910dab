#include "zip.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <ostream>

#include "../files/files.hpp"
#include "bytes.hpp"

namespace vcell {

namespace {

// [Zip20, section 4.4.7]: the remainder modulo the reflected polynomial, byte by byte.
constexpr std::array<std::uint32_t, 256> crc_of_bytes = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t byte = 0; byte < 256; ++byte) {
        std::uint32_t crc = byte;
        for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320U : 0U);
        table[byte] = crc;
    }
    return table;
}();

std::uint32_t crc32(std::string_view bytes) {
    std::uint32_t crc = ~std::uint32_t{0};
    for (const char c : bytes) crc = crc >> 8 ^ crc_of_bytes[(crc ^ static_cast<unsigned char>(c)) & 0xffU];
    return ~crc;
}

// What an entry's own header and the directory both say of it, from the version that is needed on.
void add_description(Bytes& bytes, const ZipEntry& entry, std::uint32_t crc) {
    constexpr std::uint16_t version = 20, no_flags = 0, stored = 0, midnight = 0, first_of_1980 = 0x21;
    for (const std::uint16_t number : {version, no_flags, stored, midnight, first_of_1980}) bytes.add(number);
    bytes.add(crc);
    for (int packed = 0; packed < 2; ++packed) bytes.add(static_cast<std::uint32_t>(entry.content.size()));
    bytes.add(static_cast<std::uint16_t>(entry.name.size()));
    bytes.add(std::uint16_t{0});  // no extra field
}

}  // namespace

void write_zip(std::ostream& out, const std::vector<ZipEntry>& entries) {
    const auto write = [&](std::string_view text) {
        out.write(text.data(), static_cast<std::streamsize>(text.size()));
    };
    std::size_t offset = 0;
    Bytes directory;
    for (const ZipEntry& entry : entries) {
        const std::uint32_t crc = crc32(entry.content);
        Bytes header;
        header.add(std::uint32_t{0x04034b50});
        add_description(header, entry, crc);

        directory.add(std::uint32_t{0x02014b50});
        directory.add(std::uint16_t{20});  // made by this version
        add_description(directory, entry, crc);
        for (int field = 0; field < 3; ++field) directory.add(std::uint16_t{0});  // comment, disk, kind
        directory.add(std::uint32_t{0});                                          // no attributes
        directory.add(static_cast<std::uint32_t>(offset));
        directory.add_text(entry.name);

        offset += header.text().size() + entry.name.size() + entry.content.size();
        if (offset > UINT32_MAX) throw WriteError("a zip archive holds no more than 4 GB");
        write(header.text());
        write(entry.name);
        write(entry.content);
    }
    Bytes end;
    end.add(std::uint32_t{0x06054b50});
    for (int disk = 0; disk < 2; ++disk) end.add(std::uint16_t{0});
    for (int here = 0; here < 2; ++here) end.add(static_cast<std::uint16_t>(entries.size()));
    end.add(static_cast<std::uint32_t>(directory.text().size()));
    end.add(static_cast<std::uint32_t>(offset));
    end.add(std::uint16_t{0});  // no comment
    write(directory.text());
    write(end.text());
}

}  // namespace vcell
