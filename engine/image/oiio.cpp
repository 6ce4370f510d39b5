// The only file that includes OpenImageIO. Nothing thrown in here leaves it, no plug-in
// is searched for and nothing is guessed: the format comes from the first bytes of the
// file.
#include "engine/image/oiio.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <mutex>
#include <new>
#include <string>
#include <vector>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wpedantic"
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#pragma GCC diagnostic pop

#include "engine/core/color.h"
#include "engine/core/file.h"
#include "engine/image/clean.h"

namespace
{

constexpr std::uint64_t file_max = std::uint64_t(1) << 30;
// Light maps are floats, and large.
constexpr pbnds_image_limits map_limits = {0, PBNDS_LIGHT_MAP_BYTES};

enum format_bit : unsigned { PNG = 1, JPEG = 2, WEBP = 4, HDR = 8, EXR = 16 };

struct format {
    format_bit bit;
    const char *reader;
    decltype(&pbnds_clean_png) clean; // null: none needed
};

// What one decoded file holds, as floats or bytes of `channels` interleaved channels.
struct decoded {
    int width = 0, height = 0, channels = 0;
    std::vector<unsigned char> u8;
    std::vector<float> f32;
    bool integers = false; // the file's samples are integers, so display-encoded
};

void set_limits()
{
    static std::once_flag once;
    std::call_once(once, [] {
        OIIO::attribute("threads", 1);
        OIIO::attribute("exr_threads", -1);
        OIIO::attribute("try_all_readers", 0);
        OIIO::attribute("plugin_searchpath", "");
        // Every size is known before the library sees a file (size.h).
        OIIO::attribute("limits:imagesize_MB", 1 << 20);
        OIIO::attribute("limits:channels", 64);
    });
}

bool starts(const unsigned char *bytes, size_t size, size_t at, const char *magic)
{
    const size_t length = std::strlen(magic);
    return size >= at + length && std::memcmp(bytes + at, magic, length) == 0;
}

bool sniff(const unsigned char *bytes, size_t size, format *out)
{
    if (starts(bytes, size, 0, "\x89PNG\r\n\x1a\n")) {
        *out = {PNG, "png", pbnds_clean_png};
    } else if (starts(bytes, size, 0, "\xff\xd8\xff")) {
        *out = {JPEG, "jpeg", pbnds_clean_jpeg};
    } else if (starts(bytes, size, 0, "RIFF") && starts(bytes, size, 8, "WEBP")) {
        *out = {WEBP, "webp", pbnds_clean_webp};
    } else if (starts(bytes, size, 0, "#?RADIANCE") ||
               starts(bytes, size, 0, "#?RGBE")) {
        *out = {HDR, "hdr", nullptr};
    } else if (starts(bytes, size, 0, "\x76\x2f\x31\x01")) {
        *out = {EXR, "openexr", nullptr};
    } else {
        return false;
    }
    return true;
}

// The library's messages can be paragraphs, and quote what they found: keeps the first
// line in printable ASCII, without a full stop.
std::string first_line(const std::string &message)
{
    std::string line = message.substr(0, message.find('\n'));
    for (char &c : line) {
        if (c < 0x20 || c > 0x7e) c = '?';
    }
    while (!line.empty() && (line.back() == '.' || line.back() == ' '))
        line.pop_back();
    return line.empty() ? "no reason given" : line;
}

pbnds_status fail_damaged(const char *name, const std::string &reason,
                          pbnds_error *error)
{
    if (reason.find("limits:") != std::string::npos) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "%s: the image is too large, scale it down", name);
    }
    return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: image is damaged: %s", name,
                      first_line(reason).c_str());
}

int channel_index(const OIIO::ImageSpec &spec, const char *name)
{
    for (int c = 0; c < spec.nchannels; ++c) {
        if (spec.channelnames[size_t(c)] == name) return c;
    }
    return -1;
}

// The channels that make up the picture, as a run [*begin, *end): all of a picture
// file, R, G, B and A of an OpenEXR file, or its luminance.
bool picture_channels(const OIIO::ImageSpec &spec, format_bit bit, int *begin, int *end)
{
    *begin = 0;
    *end = spec.nchannels;
    if (bit != EXR) return spec.nchannels >= 1 && spec.nchannels <= 4;
    const int r = channel_index(spec, "R");
    if (r >= 0 && channel_index(spec, "G") == r + 1 &&
        channel_index(spec, "B") == r + 2) {
        *begin = r;
        *end = channel_index(spec, "A") == r + 3 ? r + 4 : r + 3;
        return true;
    }
    const int y = channel_index(spec, "Y");
    if (y < 0 && spec.nchannels != 1) return false;
    *begin = y < 0 ? 0 : y;
    *end = *begin + 1;
    return true;
}

// The library may read the header otherwise than we do: what it found is what counts.
pbnds_status check_size(const OIIO::ImageSpec &spec, const pbnds_image_size &expected,
                        const char *name, pbnds_error *error)
{
    if (spec.width != expected.width || spec.height != expected.height ||
        spec.depth > 1) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: image is damaged: %d x %d or %d x %d x %d pixels", name,
                          expected.width, expected.height, spec.width, spec.height,
                          spec.depth);
    }
    // The library makes room for whole tiles, even where the image is smaller than one.
    if (spec.tile_width > std::max(spec.width, 4096) ||
        spec.tile_height > std::max(spec.height, 4096)) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY,
                          "%s: tiles of %d x %d pixels are too large, store scan lines",
                          name, spec.tile_width, spec.tile_height);
    }
    return PBNDS_OK;
}

// Picture files row by row: a whole image goes through 64 MiB of the library's, whatever
// its size.
bool read_samples(OIIO::ImageInput &in, format_bit bit, int begin, int end,
                  OIIO::TypeDesc type, void *out, size_t size)
{
    if (bit == EXR) return in.read_image(0, 0, begin, end, type, out);
    const int height = in.spec().height;
    const size_t row = size / size_t(height);
    for (int y = 0; y < height; ++y) {
        char *to = static_cast<char *>(out) + size_t(y) * row;
        if (!in.read_scanline(y + in.spec().y, 0, type, to)) return false;
    }
    return true;
}

pbnds_status read_pixels(OIIO::ImageInput &in, format_bit bit,
                         const pbnds_image_size &expected, const char *name,
                         decoded *out, pbnds_error *error)
{
    const OIIO::ImageSpec spec = in.spec();
    if (spec.deep) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: deep images are not supported, flatten it", name);
    }
    const bool bytes = spec.format == OIIO::TypeDesc::UINT8;
    const pbnds_status status = check_size(spec, expected, name, error);
    if (status != PBNDS_OK) return status;
    if (!bytes &&
        expected.bytes / 16 < std::uint64_t(spec.width) * unsigned(spec.height)) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT,
                          "%s: image is damaged: its samples are not of 8 bits", name);
    }
    int begin = 0, end = 0;
    if (!picture_channels(spec, bit, &begin, &end)) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: has no channels R, G and B (or a single one) to make a "
                          "picture of",
                          name);
    }
    out->width = spec.width;
    out->height = spec.height;
    out->channels = end - begin;
    out->integers = !spec.format.is_floating_point() && bit != EXR;
    const size_t count =
        size_t(spec.width) * size_t(spec.height) * size_t(out->channels);
    bool good;
    if (bytes) {
        out->u8.resize(count);
        good = read_samples(in, bit, begin, end, OIIO::TypeDesc::UINT8, out->u8.data(),
                            out->u8.size());
    } else {
        out->f32.resize(count);
        good = read_samples(in, bit, begin, end, OIIO::TypeDesc::FLOAT, out->f32.data(),
                            out->f32.size() * sizeof(float));
    }
    return good ? PBNDS_OK : fail_damaged(name, in.geterror(), error);
}

// The library's own reader from memory adds offset and size before it compares them: an
// offset of -1 in a damaged file passes, and reads what lies before the bytes.
class memory_file final : public OIIO::Filesystem::IOMemReader
{
  public:
    memory_file(const unsigned char *bytes, size_t size)
        : IOMemReader(const_cast<unsigned char *>(bytes), size), bytes_(bytes),
          size_(size)
    {
    }
    bool seek(std::int64_t offset) override
    {
        if (offset < 0 || std::uint64_t(offset) > size_) return false;
        m_pos = offset;
        return true;
    }
    size_t pread(void *out, size_t size, std::int64_t offset) override
    {
        if (offset < 0 || std::uint64_t(offset) >= size_) return 0;
        const size_t n = std::min(size, size_ - size_t(offset));
        std::memcpy(out, bytes_ + offset, n);
        return n;
    }
    size_t read(void *out, size_t size) override
    {
        const size_t n = pread(out, size, m_pos);
        m_pos += std::int64_t(n);
        return n;
    }

  private:
    const unsigned char *bytes_;
    size_t size_;
};

pbnds_status decode_as(const format &kind, const pbnds_image_size &expected,
                       const unsigned char *bytes, size_t size, const char *name,
                       decoded *out, pbnds_error *error)
{
    memory_file memory(bytes, size);
    const std::unique_ptr<OIIO::ImageInput> in = OIIO::ImageInput::create(kind.reader);
    if (!in) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: this OpenImageIO was built without %s", name,
                          kind.reader);
    }
    OIIO::ImageSpec config, spec;
    config.attribute("oiio:UnassociatedAlpha", 1);
    if (!in->set_ioproxy(&memory) || !in->open(name, spec, config)) {
        return fail_damaged(name, in->geterror(), error);
    }
    const pbnds_status status = read_pixels(*in, kind.bit, expected, name, out, error);
    in->close();
    return status;
}

pbnds_status decode(const unsigned char *bytes, size_t size, unsigned allowed,
                    const pbnds_image_limits *limits, const char *name, decoded *out,
                    pbnds_error *error)
{
    set_limits();
    format kind;
    if (size == 0) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: the image is empty", name);
    }
    if (!sniff(bytes, size, &kind) || !(kind.bit & allowed)) {
        return pbnds_fail(error, PBNDS_ERROR_UNSUPPORTED,
                          "%s: not an image that can be read here, convert it to PNG, "
                          "JPEG, Radiance HDR or OpenEXR",
                          name);
    }
    pbnds_image_size expected;
    pbnds_status status =
        pbnds_image_measure(bytes, size, name, limits, &expected, error);
    if (status != PBNDS_OK) return status;
    if (!kind.clean) return decode_as(kind, expected, bytes, size, name, out, error);
    std::uint8_t *clean = nullptr;
    size_t clean_size = 0;
    status = kind.clean(bytes, size, name, &clean, &clean_size, error);
    const std::unique_ptr<std::uint8_t, void (*)(void *)> owner(clean, std::free);
    return status == PBNDS_OK
               ? decode_as(kind, expected, clean, clean_size, name, out, error)
               : status;
}

// Runs f and turns whatever it throws into an error.
template <class F> pbnds_status guarded(const char *name, pbnds_error *error, F &&f)
{
    try {
        return f();
    } catch (const std::bad_alloc &) {
        return pbnds_fail(error, PBNDS_ERROR_MEMORY, "%s: no memory for the image",
                          name);
    } catch (const std::exception &e) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: image is damaged: %s", name,
                          first_line(e.what()).c_str());
    } catch (...) {
        return pbnds_fail(error, PBNDS_ERROR_FORMAT, "%s: image is damaged", name);
    }
}

// 1 to 4 channels to four: grey, grey and alpha, colour, colour and alpha.
template <class T>
T *spread_rgba(const std::vector<T> &in, int channels, T opaque, size_t pixels)
{
    T *out = static_cast<T *>(std::malloc(pixels * 4 * sizeof(T)));
    if (!out) throw std::bad_alloc();
    const bool grey = channels < 3;
    for (size_t i = 0; i < pixels; ++i) {
        const T *p = in.data() + i * size_t(channels);
        T *q = out + 4 * i;
        q[0] = p[0];
        q[1] = grey ? p[0] : p[1];
        q[2] = grey ? p[0] : p[2];
        q[3] = channels == 2 || channels == 4 ? p[channels - 1] : opaque;
    }
    return out;
}

// Largest finite value of the file, for what is infinite in it.
float largest(const std::vector<float> &data)
{
    float most = 0.0f;
    for (const float x : data) {
        if (std::isfinite(x) && x > most) most = x;
    }
    return most;
}

void tame(std::vector<float> &data)
{
    const float most = largest(data);
    for (float &x : data) {
        if (!(x > 0.0f)) x = 0.0f; // NaN too
        if (x > most) x = most;
    }
}

pbnds_status to_rgb(decoded &picture, pbnds_image *image, pbnds_error *error)
{
    const pbnds_status status =
        pbnds_image_init(image, picture.width, picture.height, 3, error);
    if (status != PBNDS_OK) return status;
    float linear[256];
    for (int i = 0; i < 256; ++i)
        linear[i] = pbnds_srgb_decode(float(i) / 255.0f);
    const bool bytes = !picture.u8.empty();
    if (!bytes && !picture.integers) tame(picture.f32);
    const size_t n = size_t(picture.channels), green = n < 3 ? 0 : 1,
                 blue = n < 3 ? 0 : 2;
    const size_t pixels = size_t(picture.width) * size_t(picture.height);
    const size_t source[3] = {0, green, blue};
    for (size_t i = 0; i < pixels; ++i) {
        for (size_t c = 0; c < 3; ++c) {
            const size_t k = i * n + source[c];
            float x = bytes ? linear[picture.u8[k]] : picture.f32[k];
            if (!bytes && picture.integers) x = pbnds_srgb_decode(x);
            image->data[3 * i + c] = x;
        }
    }
    return PBNDS_OK;
}

pbnds_status encode_png(const pbnds_image &image, const char *path,
                        std::vector<unsigned char> *out, pbnds_error *error)
{
    set_limits();
    const size_t count =
        size_t(image.width) * size_t(image.height) * size_t(image.channels);
    std::vector<unsigned char> bytes(count);
    for (size_t i = 0; i < count; ++i) {
        const float x = image.data[i];
        bytes[i] = static_cast<unsigned char>(
            x > 0.0f ? std::floor(std::fmin(x, 1.0f) * 255.0f + 0.5f) : 0.0f);
    }
    const std::unique_ptr<OIIO::ImageOutput> png = OIIO::ImageOutput::create("png");
    OIIO::ImageSpec spec(image.width, image.height, image.channels,
                         OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("oiio:UnassociatedAlpha", 1);
    OIIO::Filesystem::IOVecOutput memory(*out);
    const bool good = png && png->set_ioproxy(&memory) && png->open(path, spec) &&
                      png->write_image(OIIO::TypeDesc::UINT8, bytes.data()) &&
                      png->close();
    if (good) return PBNDS_OK;
    return pbnds_fail(error, PBNDS_ERROR_IO, "%s: PNG cannot be made: %s", path,
                      png ? first_line(png->geterror()).c_str() : "no PNG writer");
}

} // namespace

extern "C" pbnds_status pbnds_pixels_decode(const void *bytes, size_t size,
                                            const char *name, pbnds_pixels *pixels,
                                            pbnds_error *error)
{
    return pbnds_pixels_decode_within(bytes, size, name, nullptr, pixels, error);
}

extern "C" pbnds_status pbnds_pixels_decode_within(const void *bytes, size_t size,
                                                   const char *name,
                                                   const pbnds_image_limits *limits,
                                                   pbnds_pixels *pixels,
                                                   pbnds_error *error)
{
    *pixels = pbnds_pixels{0, 0, 0, nullptr, nullptr};
    return guarded(name, error, [&] {
        decoded picture;
        const pbnds_status status =
            decode(static_cast<const unsigned char *>(bytes), size,
                   PNG | JPEG | WEBP | HDR | EXR, limits, name, &picture, error);
        if (status != PBNDS_OK) return status;
        const size_t count = size_t(picture.width) * size_t(picture.height);
        if (picture.u8.empty()) {
            pixels->f32 = spread_rgba(picture.f32, picture.channels, 1.0f, count);
        } else {
            pixels->u8 =
                spread_rgba<unsigned char>(picture.u8, picture.channels, 255, count);
        }
        pixels->width = picture.width;
        pixels->height = picture.height;
        pixels->channels = 4;
        return PBNDS_OK;
    });
}

extern "C" void pbnds_pixels_free(pbnds_pixels *pixels)
{
    std::free(pixels->u8);
    std::free(pixels->f32);
    *pixels = pbnds_pixels{0, 0, 0, nullptr, nullptr};
}

extern "C" pbnds_status pbnds_image_read_rgb(const char *path, pbnds_image *image,
                                             pbnds_error *error)
{
    return pbnds_image_read_rgb_within(path, nullptr, image, error);
}

extern "C" pbnds_status pbnds_image_read_rgb_within(const char *path,
                                                    const pbnds_image_limits *limits,
                                                    pbnds_image *image,
                                                    pbnds_error *error)
{
    *image = pbnds_image{0, 0, 0, nullptr};
    std::uint8_t *bytes = nullptr;
    size_t size = 0;
    pbnds_status status = pbnds_file_read(path, file_max, &bytes, &size, error);
    if (status != PBNDS_OK) return status;
    status = guarded(path, error, [&] {
        decoded picture;
        const pbnds_status decoding =
            decode(bytes, size, PNG | JPEG | HDR | EXR, limits ? limits : &map_limits,
                   path, &picture, error);
        return decoding == PBNDS_OK ? to_rgb(picture, image, error) : decoding;
    });
    std::free(bytes);
    return status;
}

extern "C" pbnds_status pbnds_png_write(const char *path, const pbnds_image *image,
                                        pbnds_error *error)
{
    if (!image->data ||
        (image->channels != 1 && image->channels != 3 && image->channels != 4)) {
        return pbnds_fail(error, PBNDS_ERROR_ARGUMENT,
                          "%s: a PNG has 1, 3 or 4 channels, not %d", path,
                          image->channels);
    }
    std::vector<unsigned char> png;
    const pbnds_status status =
        guarded(path, error, [&] { return encode_png(*image, path, &png, error); });
    return status == PBNDS_OK ? pbnds_file_write(path, png.data(), png.size(), error)
                              : status;
}
