//! Hands the sources to the program: a stored result is believed only by the code that computed it (`src/runner/code.rs`).

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{env, fs};

/// Packages whose versions may change numbers.
const NUMERIC: [&str; 16] = [
    "chacha20",
    "dyn-stack",
    "faer",
    "gemm",
    "libm",
    "matrixmultiply",
    "nalgebra",
    "nano-gemm",
    "num-complex",
    "private-gemm",
    "pulp",
    "rand",
    "rayon",
    "reborrow",
    "simba",
    "statrs",
];

fn main() {
    println!("cargo:rerun-if-changed=src");
    println!("cargo:rerun-if-changed=Cargo.lock");
    let mut sources = BTreeMap::new();
    read(Path::new("src"), &mut sources);
    sources.insert("packages".to_owned(), packages(&fs::read_to_string("Cargo.lock").unwrap_or_default()));
    let lines = sources.iter().map(|(name, text)| format!("    ({name:?}, {:?}),\n", digest(text)));
    let text = format!("const SOURCES: &[(&str, [u64; 2])] = &[\n{}];\n", lines.collect::<String>());
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo names the folder"));
    fs::write(out.join("sources.rs"), text).expect("cargo's folder can be written");
}

/// The code of every source below `folder`, by its path below `src/`.
fn read(folder: &Path, sources: &mut BTreeMap<String, String>) {
    for entry in fs::read_dir(folder).expect("the sources can be listed").flatten() {
        let path = entry.path();
        if path.is_dir() {
            read(&path, sources);
        } else if path.extension().is_some_and(|end| end == "rs") {
            let name = path.strip_prefix("src").unwrap_or(&path).to_string_lossy().replace('\\', "/");
            sources.insert(name, code(&fs::read_to_string(&path).expect("a source can be read")));
        }
    }
}

/// What of a source counts: neither tests at its end nor lines of comment, nor how it is laid out.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let lines = text.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.flat_map(str::chars).filter(|letter| !letter.is_whitespace()).collect()
}

/// Names and versions of the packages that numbers may depend on.
fn packages(lock: &str) -> String {
    let numeric = |name: &str| NUMERIC.iter().any(|known| name == *known || name.starts_with(&format!("{known}-")));
    let mut found = String::new();
    for package in lock.split("[[package]]") {
        let field = |key: &str| package.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(" = "));
        if let (Some(name), Some(version)) = (field("name"), field("version"))
            && numeric(name.trim_matches('"'))
        {
            found += &format!("{name} {version}\n");
        }
    }
    found
}

/// Fowler, Noll and Vo's FNV-1a, 128 bits: tells sources apart and guards against nobody.
fn digest(text: &str) -> [u64; 2] {
    let step = |hash: u128, byte: u8| (hash ^ u128::from(byte)).wrapping_mul((1 << 88) + 0x13b);
    let hash = text.bytes().fold(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d, step);
    [(hash >> 64) as u64, hash as u64]
}
