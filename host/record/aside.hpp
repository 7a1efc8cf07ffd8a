/// A file that is written beside its place and takes it when complete.
#pragma once
#include "host/record/record.hpp"

namespace palpate::record {

class AsideFile {
public:
    /// Throws Error `FILE: cannot be written (reason)`, like the rest.
    explicit AsideFile(std::filesystem::path file);
    ~AsideFile();  ///< without commit() nothing remains
    AsideFile(const AsideFile&) = delete;
    AsideFile& operator=(const AsideFile&) = delete;
    void add(const void* bytes, std::size_t n_bytes);
    void commit();

private:
    [[noreturn]] void fail(int error);
    std::filesystem::path final_, aside_;
    int fd_ = -1;
    bool committed_ = false;
};

}  // namespace palpate::record
