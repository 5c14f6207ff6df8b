//! `cargo xtask circles`: checks that the modules of each crate form an acyclic graph.
//!
//! Module A uses module B when A names an item that B defines, directly or through re-exports. A module
//! that only re-exports the items of its child modules does not use them. Test code is not checked.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use syn::punctuated::Punctuated;
use syn::visit::{self, Visit};

use xtask_common::Failure;

use crate::files::{entries, is_for_tests};

/// The packages to check.
#[derive(Debug, clap::Args)]
pub(crate) struct Circles {
    /// The folders of the packages; all of the workspace by default
    #[arg(value_name = "DIR")]
    packages: Vec<PathBuf>,
}

/// A path of names from the root of a crate.
type Names = Vec<String>;

/// The names in a file of a crate.
#[derive(Default)]
struct Module {
    file: PathBuf,
    /// Local names of other paths, by `use`.
    aliases: BTreeMap<String, Names>,
    /// Paths with a glob import.
    globs: Vec<Names>,
    /// The names that are used here, except re-exports of inner modules.
    named: BTreeSet<Names>,
}

type Crate = BTreeMap<Names, Module>;

/// For each file the files that it uses, with one of the names.
type Uses = BTreeMap<Names, BTreeMap<Names, String>>;

pub(crate) fn run(options: &Circles) -> Result<(), Failure> {
    let packages =
        if options.packages.is_empty() { workspace_packages()? } else { options.packages.clone() };
    let mut files = 0;
    let mut circles = 0;
    for package in &packages {
        let modules = read_crate(&package.join("src"))?;
        files += modules.len();
        let uses = uses(&modules);
        for circle in strong_components(&uses) {
            circles += 1;
            print_circle(package, &circle, &modules, &uses);
        }
    }
    println!("{} packages, {files} files, {circles} circles", packages.len());
    if circles == 0 { Ok(()) } else { Err(failure(circles)) }
}

fn failure(circles: usize) -> Failure {
    Failure::Check(format!(
        "{circles} circles of modules that use each other; move what both need into a module below both"
    ))
}

fn workspace_packages() -> Result<Vec<PathBuf>, Failure> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut packages = Vec::new();
    for folder in [".", "crates", "xtask", "benches", "fuzz"] {
        packages.extend(entries(&root.join(folder))?);
    }
    packages.retain(|package| package.join("src").is_dir());
    packages.sort();
    Ok(packages)
}

fn print_circle(package: &Path, circle: &[Names], modules: &Crate, uses: &Uses) {
    println!("{}: {} files in a circle", package.display(), circle.len());
    for from in circle {
        for (to, name) in uses.get(from).into_iter().flatten() {
            if circle.contains(to) {
                let file = |names| modules.get(names).map_or_else(String::new, Module::shown);
                println!("  {} uses {name} of {}", file(from), file(to));
            }
        }
    }
}

impl Module {
    fn shown(&self) -> String {
        self.file.display().to_string()
    }
}

fn read_crate(source: &Path) -> Result<Crate, Failure> {
    let mut modules = Crate::new();
    read_folder(source, &Names::new(), &mut modules)?;
    let paths: BTreeSet<Names> = modules.keys().cloned().collect();
    for (path, module) in &mut modules {
        let file = module.file.clone();
        let text = fs::read_to_string(&file).map_err(Failure::reading(&file))?;
        let parsed = syn::parse_file(&text).map_err(Failure::reading(&file))?;
        let mut reader = Reader { path, paths: &paths, depth: 0, module };
        reader.visit_file(&parsed);
    }
    Ok(modules)
}

fn read_folder(folder: &Path, path: &Names, modules: &mut Crate) -> Result<(), Failure> {
    for file in entries(folder)? {
        let Some(stem) = file.file_stem().and_then(|stem| stem.to_str()) else { continue };
        let mut inner = path.clone();
        inner.push(stem.to_owned());
        if file.is_dir() {
            // Other programs are separate roots.
            if stem != "bin" {
                read_folder(&file, &inner, modules)?;
            }
        } else if file.extension().is_some_and(|extension| extension == "rs") {
            let is_page = stem == "mod" || path.is_empty() && (stem == "lib" || stem == "main");
            let names = if is_page { path.clone() } else { inner };
            modules.insert(names, Module { file, ..Module::default() });
        }
    }
    Ok(())
}

/// Collects the names of one file.
struct Reader<'a> {
    path: &'a Names,
    paths: &'a BTreeSet<Names>,
    /// The number of modules inside the file around the current item.
    depth: usize,
    module: &'a mut Module,
}

impl Reader<'_> {
    /// The path from the root of the crate; `None` for items from elsewhere.
    fn absolute(&self, names: &[String]) -> Option<Names> {
        let (first, rest) = names.split_first()?;
        let above = |levels: usize| self.path.len().checked_sub(levels).map(|n| &self.path[..n]);
        match first.as_str() {
            "crate" => Some(rest.to_vec()),
            "self" => Some([self.path, rest].concat()),
            "super" => {
                let supers = names.iter().take_while(|name| *name == "super").count();
                // Inside the file, `super` is the file itself.
                let base = above(supers.saturating_sub(self.depth))?;
                Some([base, &names[supers..]].concat())
            }
            _ => {
                let child = [self.path.as_slice(), &names[..1]].concat();
                self.paths.contains(&child).then(|| [self.path, names].concat())
            }
        }
    }

    fn read_use(&mut self, tree: &syn::UseTree, before: &Names, passes_on: bool) {
        match tree {
            syn::UseTree::Path(path) => {
                let names = [before.as_slice(), &[path.ident.to_string()]].concat();
                self.read_use(&path.tree, &names, passes_on);
            }
            syn::UseTree::Name(name) if name.ident == "self" => {
                self.take(before.last().cloned(), before, passes_on);
            }
            syn::UseTree::Name(name) => {
                let ident = name.ident.to_string();
                let names = [before.as_slice(), std::slice::from_ref(&ident)].concat();
                self.take(Some(ident), &names, passes_on);
            }
            syn::UseTree::Rename(rename) => {
                let names = [before.as_slice(), &[rename.ident.to_string()]].concat();
                self.take(Some(rename.rename.to_string()), &names, passes_on);
            }
            syn::UseTree::Glob(_) => {
                if let Some(path) = self.absolute(before) {
                    if !(passes_on && path.starts_with(self.path)) {
                        self.module.named.insert(path.clone());
                    }
                    self.module.globs.push(path);
                }
            }
            syn::UseTree::Group(group) => {
                for item in &group.items {
                    self.read_use(item, before, passes_on);
                }
            }
        }
    }

    fn take(&mut self, name: Option<String>, names: &Names, passes_on: bool) {
        let Some(path) = self.absolute(names) else { return };
        if !(passes_on && path.starts_with(self.path)) {
            self.module.named.insert(path.clone());
        }
        if let Some(name) = name.filter(|_| self.depth == 0) {
            self.module.aliases.insert(name, path);
        }
    }
}

impl<'ast> Visit<'ast> for Reader<'_> {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        let attributes = match item {
            syn::Item::Mod(item) => &item.attrs,
            syn::Item::Fn(item) => &item.attrs,
            syn::Item::Impl(item) => &item.attrs,
            syn::Item::Use(item) => &item.attrs,
            _ => return visit::visit_item(self, item),
        };
        if !attributes.iter().any(is_for_tests) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        self.depth += 1;
        visit::visit_item_mod(self, item);
        self.depth -= 1;
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        let passes_on = !matches!(item.vis, syn::Visibility::Inherited);
        self.read_use(&item.tree, &Names::new(), passes_on);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Names = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        if names.len() > 1
            && let Some(path) = self.absolute(&names)
        {
            self.module.named.insert(path);
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, item: &'ast syn::Macro) {
        // The arguments of most macros are expressions.
        let parser = Punctuated::<syn::Expr, syn::Token![,]>::parse_terminated;
        if let Ok(arguments) = item.parse_body_with(parser) {
            for argument in &arguments {
                self.visit_expr(argument);
            }
        }
    }
}

fn uses(modules: &Crate) -> Uses {
    let mut uses = Uses::new();
    for (path, module) in modules {
        let used = uses.entry(path.clone()).or_default();
        for named in &module.named {
            let home = home_of(modules, &Names::new(), named, 16);
            if home != *path {
                used.insert(home, named.join("::"));
            }
        }
    }
    uses
}

/// The module that defines `names`, seen from `module`.
fn home_of(modules: &Crate, module: &Names, names: &[String], patience: usize) -> Names {
    let Some((first, rest)) = names.split_first() else { return module.clone() };
    let inner = [module.as_slice(), std::slice::from_ref(first)].concat();
    if modules.contains_key(&inner) {
        return home_of(modules, &inner, rest, patience);
    }
    let Some(known) = modules.get(module) else { return module.clone() };
    let Some(patience) = patience.checked_sub(1) else { return module.clone() };
    if let Some(alias) = known.aliases.get(first) {
        let names = [alias.as_slice(), rest].concat();
        return home_of(modules, &Names::new(), &names, patience);
    }
    for glob in &known.globs {
        let target = modules.get(glob);
        if target.is_some_and(|target| target.aliases.contains_key(first)) {
            return home_of(modules, glob, names, patience);
        }
    }
    module.clone()
}

/// Groups of several files that can reach each other.
fn strong_components(uses: &Uses) -> Vec<Vec<Names>> {
    let reach: BTreeMap<&Names, BTreeSet<&Names>> = uses
        .keys()
        .map(|start| {
            let mut seen = BTreeSet::new();
            let mut open = vec![start];
            while let Some(file) = open.pop() {
                let next = uses.get(file).into_iter().flat_map(BTreeMap::keys);
                open.extend(next.filter(|next| seen.insert(*next)));
            }
            (start, seen)
        })
        .collect();
    let mut done = BTreeSet::new();
    let mut components = Vec::new();
    for (start, reached) in &reach {
        if !reached.contains(start) || !done.insert(*start) {
            continue;
        }
        let back = |file: &&Names| reach.get(*file).is_some_and(|seen| seen.contains(start));
        let component: Vec<Names> = reached.iter().copied().filter(back).cloned().collect();
        done.extend(reached.iter().copied().filter(back));
        components.push(component);
    }
    components
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circles_of(files: &[(&str, &str)]) -> Vec<Vec<String>> {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let file = folder.path().join(name);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(file, text).unwrap();
        }
        let modules = read_crate(folder.path()).unwrap();
        let circles = strong_components(&uses(&modules));
        circles.iter().map(|circle| circle.iter().map(|file| file.join("::")).collect()).collect()
    }

    #[test]
    fn a_circle_through_re_exports_is_found() {
        let circles = circles_of(&[
            ("lib.rs", "mod a; mod b; pub use a::A; pub use b::B;"),
            ("a.rs", "use crate::B; pub struct A(B);"),
            ("b.rs", "pub struct B; fn f() { let _ = crate::a::A::new(); }"),
        ]);
        assert_eq!(circles, [["a", "b"]]);
    }

    #[test]
    fn pages_that_pass_on_names_and_tests_make_no_circle() {
        let circles = circles_of(&[
            ("lib.rs", "mod cost; pub use cost::{Cost, Hybrid};"),
            ("cost.rs", "mod hybrid; pub use hybrid::Hybrid; pub trait Cost {}"),
            ("cost/hybrid.rs", "use super::Cost; pub struct Hybrid; impl Cost for Hybrid {}"),
            ("other.rs", "#[cfg(test)] mod tests { use crate::cost::Hybrid; use super::*; }"),
        ]);
        assert!(circles.is_empty(), "{circles:?}");
    }

    #[test]
    fn a_page_that_uses_its_child_and_is_used_by_it_is_a_circle() {
        let circles = circles_of(&[
            ("main.rs", "mod cost;"),
            ("cost.rs", "mod hybrid; use hybrid::Hybrid; pub trait Cost {} fn f(_: Hybrid) {}"),
            ("cost/hybrid.rs", "use super::Cost; pub struct Hybrid; impl Cost for Hybrid {}"),
        ]);
        assert_eq!(circles, [["cost", "cost::hybrid"]]);
    }
}
