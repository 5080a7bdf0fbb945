// overcoat for C++17: what C++ programs wrap around overcoat.h. Copy what you need.

#pragma once

#include <overcoat.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace overcoat_cpp {

struct Error : std::runtime_error {
    overcoat_status status;
    Error(overcoat_status status, const char *message) : std::runtime_error(message), status(status) {}
};

// An overcoat, freed when it goes out of scope.
class Renderer {
    struct Free {
        void operator()(overcoat *o) const { overcoat_free(&o); }
    };
    std::unique_ptr<overcoat, Free> own;

public:
    explicit Renderer(uint32_t threads = 0) {
        overcoat_options options;
        OVERCOAT_INIT(options);
        options.threads = threads;
        overcoat *made = nullptr;
        if (auto status = overcoat_new(&options, &made)) throw Error(status, "cannot start");
        own.reset(made);
    }
    operator overcoat *() const { return own.get(); }
    void check(overcoat_status status) const {
        if (status) throw Error(status, overcoat_message(own.get()));
    }
    std::vector<uint8_t> png(const std::vector<uint8_t> &rgba, uint32_t width, uint32_t height) const {
        uint8_t *bytes = nullptr;
        size_t length = 0;
        check(overcoat_encode_png(*this, rgba.data(), width, height, 0, &bytes, &length));
        std::vector<uint8_t> copy(bytes, bytes + length);
        overcoat_bytes_free(bytes, length);
        return copy;
    }
};

}  // namespace overcoat_cpp
