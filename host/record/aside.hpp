/// A file that is written beside its place and takes it when complete.
#pragma once
#include "host/record/record.hpp"

namespace palpate::record {

class AsideFile {
public:
    /// Of a symbolic link its target is written. Throws Error `FILE: cannot be written (reason)`, like the
    /// rest; also when FILE is there and no regular file.
    explicit AsideFile(std::filesystem::path file);
    ~AsideFile();  ///< without commit() nothing remains
    AsideFile(const AsideFile&) = delete;
    AsideFile& operator=(const AsideFile&) = delete;
    void add(const void* bytes, std::size_t n_bytes);
    void commit();

private:
    [[noreturn]] void fail(const std::string& why);
    std::filesystem::path name_, final_, aside_;  ///< as given; where it lies; beside that
    int fd_ = -1;
    bool committed_ = false;
};

}  // namespace palpate::record
